// Everything a LIDAR run leaves in an instrument's folder, written shot by shot; memory does not depend on the number
// of pulses.
//   waveforms.img     time cube: expectations and records, one line per pulse and pixel (time_cube.h)
//   returns.las       point cloud with truth; the waveforms beside it in returns.wdp, or inside
//   returns.laz       the same points, compressed
//   returns.csv       the same returns; pulses.csv: every pulse, its geometry, detection and energy ledger;
//   photons.csv       Geiger time tags
//   *.png             waveforms, ranges, points
//   run.json          how it came about
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/lidar/detection.h"
#include "host/lidar/lidar_plan.h"
#include "host/lidar/return_truth.h"
#include "host/products/run_record.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

class LidarProducts {
 public:
  /// Begins the files in `folder` that the lidar asks for; refuses at once what exists (unless replaced). What it
  /// refers to must outlive it. Pictures are left out, with a warning in the record, where Debian's python3-matplotlib
  /// is missing; LAZ without laspy and lazrs is refused.
  LidarProducts(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation,
                const lidar::LidarPlan& plan);
  ~LidarProducts();

  /// Whether a product holds what stands behind returns: then shots come with their first hits.
  bool wants_truth() const;
  /// That of a shot's records, [pixel][line][return]; left empty where nobody asks or hits are missing. Any thread may
  /// ask.
  void truth(const lidar::ShotResult& result, const std::vector<lidar::Detection>& detections,
             std::vector<std::vector<lidar::ReturnTruth>>& out) const;
  /// Next shot, in order of pulses. `detections` as lidar::detect() hands them out, [pixel][line]; empty: expectations
  /// alone, without returns, which must then be so for every shot.
  void add(const lidar::ShotResult& result, const std::vector<lidar::Detection>& detections,
           const std::vector<std::vector<lidar::ReturnTruth>>& truth);
  /// Finishes every file, fills the record's digest, files, figures and warnings, writes run.json and names them all.
  void publish(products::RunRecord& record);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::run
