// The tables of a LIDAR run as CSV. Positions are in the scene's coordinate system (origin added), times on the
// trajectory's clock.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/lidar/detection.h"
#include "host/lidar/lidar_plan.h"
#include "host/lidar/return_truth.h"
#include "host/products/csv_writer.h"
#include "host/products/run_record.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// The line's name, or its number from 1.
std::string line_name(const scene::Lidar& lidar, int line);

/// ASPRS class of a return: noise, its material's, or unclassified.
int las_class_of(const scene::Simulation& simulation, const scene::Lidar& lidar, const lidar::Echo& echo,
                 const lidar::ReturnTruth& truth);

/// returns.csv (a row per return), pulses.csv (a row per pulse and line) and, of Geiger detectors, photons.csv (a row
/// per event).
class LidarCsv {
 public:
  LidarCsv(base::OutputSet& set, const scene::Simulation& simulation, const lidar::LidarPlan& plan);

  void add_return(const lidar::Shot& shot, const lidar::Detection& record, const lidar::Echo& echo,
                  const lidar::Vec3& at_m, const lidar::ReturnTruth& truth);
  void add_photons(const lidar::Detection& record);
  /// cube_line: of the pulse's first pixel in the time cube. Records' figures are means over the pixels, sums where
  /// they count.
  void add_shot(const lidar::ShotResult& result, const std::vector<lidar::Detection>& detections,
                std::int64_t cube_line);
  void finish(products::RunRecord& record);

 private:
  const scene::Simulation& simulation_;
  const lidar::LidarPlan& plan_;
  products::CsvWriter pulses_, returns_;
  std::optional<products::CsvWriter> photons_;
};

}  // namespace raycube::run
