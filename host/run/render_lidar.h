// A LIDAR's run, from shots to products.
#pragma once

#include <cstdint>
#include <string>

#include "host/render/renderer.h"
#include "host/run/camera_job.h"
#include "host/run/destination.h"
#include "host/run/lidar_job.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// What is told of a survey that is whole.
struct LidarRun {
  std::string name, folder;
  std::string digest;     ///< of the products
  std::string main_file;  ///< the first of point cloud, time cube and record that there is
  std::int64_t pulses = 0;
  std::uint64_t returns = 0;
  double seconds = 0, pulses_per_s = 0;
  double worst_ledger_error = 0;  ///< of a pulse's light, what the ledger does not account for
};

/// Fires every pulse of the survey, batch by batch: shots, turbulence, background light, expectations, detection,
/// products. Sub-rays that the file does not give are the planner's, or those of the plan that is replayed. Memory does
/// not grow with the number of pulses.
LidarRun render_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar,
                      const render::RenderOptions& options, const Destination& destination, Services& services,
                      const Planning& planning);

/// What a run would take.
struct LidarForecast {
  LidarJob job;
  std::uint64_t rays = 0;  ///< first rays of the survey
  std::int64_t pulses_per_batch = 0;
  std::uint64_t waveform_bytes = 0;
};

/// Plans as the run would, with a trial where there is a device.
LidarForecast forecast_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar,
                             const render::RenderOptions& options, Services& services, const Planning& planning);

}  // namespace raycube::run
