// Fires chosen pulses of one LIDAR on the device and holds them against the reference.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/reference/lidar_compare.h"
#include "host/render/lidar_renderer.h"
#include "host/run/lidar_job.h"
#include "host/run/services.h"

namespace raycube::run {

struct LidarCheckOptions {
  std::uint64_t pulses = 100;  ///< all of the survey when it has fewer
  int threads = 0;             ///< of the reference; 0: all
};

/// The pulses to check: picked by a hash of the seed and a counter, in order of number; what a scanner does not fire is
/// passed over.
std::vector<lidar::Shot> pick_shots(const scene::Lidar& lidar, std::uint64_t seed, std::uint64_t pulses);

/// 100, or as many as have 3e5 rays; at least 2.
std::uint64_t default_pulses(const lidar::LidarPlan& plan);

/// Expectations as the plan has them: turbulence and scintillation are drawn later and are not in it. `progress`:
/// called with the number of pulses compared since the last call.
reference::LidarReport check_lidar(render::LidarRenderer& renderer, const scene::CompiledScene& scene,
                                   const lidar::LidarPlan& plan, const LidarCheckOptions& options,
                                   const std::function<void(std::uint64_t)>& progress = {});

/// The same of a survey's job, told as it goes.
reference::LidarReport check_survey(render::LidarRenderer& renderer, const scene::Simulation& simulation,
                                    const LidarJob& job, const LidarCheckOptions& options, const Services& services);

}  // namespace raycube::run
