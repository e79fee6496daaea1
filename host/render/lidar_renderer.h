// Pulses on one device: a compiled scene uploaded once, then shots in batches that the memory budget allows.
//
//   records of shots (double, host) -> lidar_shots: rays, rows of expected photons, ledger -> lidar_air -> results in
//   order
//
// One work-item owns a shot's rows (receiver sampling: a pixel's) and adds to them in the order of its rays: batches,
// threads and work-groups cannot change a bit. Points are kept relative to a place of the shot near the scene, so
// ranges of hundreds of kilometres lose nothing.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "host/render/renderer.h"

namespace raycube::render {

using ShotSink = std::function<void(lidar::ShotResult&&)>;

class LidarRenderer {
 public:
  /// Uploads the scene. Throws Error(device | environment | input) when there is no device or the scene does not fit.
  LidarRenderer(const scene::CompiledScene& scene, const RenderOptions& options);
  ~LidarRenderer();
  LidarRenderer(LidarRenderer&&) noexcept;

  /// Computes the shots' expectations and hands them to the sink in order. `hits`: with first hits. Throws
  /// Error(interrupted) on Ctrl-C, Error(input) when a single shot's rows do not fit the memory budget.
  void render(const lidar::LidarPlan& plan, const std::vector<lidar::Shot>& shots, const ShotSink& sink,
              bool hits = false);

  std::string device_name() const;
  /// What launches use now.
  DeviceTuning tuning() const;
  /// Its sizes of launches may be set, and kernels timed, between renders.
  cl::Context& context();
  /// Wall seconds of the last render()'s launches: tracing and binning, without moving data to and from the device.
  double launch_s() const;
  /// SHA-256 of source and options of the programs of the last render().
  std::string program_hash() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::render
