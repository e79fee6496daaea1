// A small LIDAR plan and rows of Gaussian returns, for tests of detection and echoes.
#pragma once

#include <cmath>

#include "host/lidar/lidar_plan.h"
#include "tests/support/seeds.h"

namespace raycube::test {

inline constexpr double kSigmaOfFwhm = 0.42466090014400953;

/// 4 ns pulse at 1064 nm, 1 ns bins from 6600 ns, one pixel, one line, quantum efficiency 1.
inline lidar::LidarPlan small_plan(int bins = 200) {
  lidar::LidarPlan plan;
  plan.seed = testing::seed(7);
  scene::LidarLine line;
  line.wavelength_um = 1.064;
  plan.lidar.pulse.lines = {line};
  plan.lidar.pulse.fwhm_s = 4e-9;
  plan.lidar.pulse.half_divergence_rad = 2.5e-4;
  plan.lidar.receiver.aperture_radius_m = 0.05;
  plan.lidar.receiver.half_fov_rad = 5e-4;
  plan.lidar.gate = {6600e-9, 1e-9, bins};
  plan.photons = {1e14};
  return plan;
}

/// Adds a Gaussian return integrated over the bins; position in bins from the gate's start.
inline void add_return(std::vector<float>& row, double photons, double position, double sigma_bins) {
  const auto below = [&](double edge) { return 0.5 * std::erfc((position - edge) / (sigma_bins * std::sqrt(2.0))); };
  for (std::size_t i = 0; i < row.size(); ++i)
    row[i] += static_cast<float>(photons * (below(static_cast<double>(i) + 1) - below(static_cast<double>(i))));
}

inline lidar::ShotResult empty_shot(const lidar::LidarPlan& plan, std::int64_t pulse = 0) {
  lidar::ShotResult shot;
  shot.shot.pulse = pulse;
  shot.shot.half_divergence_rad = plan.lidar.pulse.half_divergence_rad;
  shot.first.assign(static_cast<std::size_t>(plan.pixels() * plan.lines() * plan.lidar.gate.bins), 0.0F);
  return shot;
}

}  // namespace raycube::test
