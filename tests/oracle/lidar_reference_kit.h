// Shots of the LIDAR reference over scenes of tests/support/lidar_kit.h.
#pragma once

#include <numeric>

#include "host/reference/lidar_shot.h"
#include "tests/support/lidar_kit.h"

namespace raycube::test {

inline reference::LidarReference shoot(const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                                       const lidar::Shot& shot, const reference::LidarShotOptions& options = {}) {
  const reference::EmbreeScene embree(scene);
  return reference::reference_shot(scene, embree, plan, shot, options);
}

inline double row_sum(const std::vector<double>& row) { return std::accumulate(row.begin(), row.end(), 0.0); }

/// Middle of a waveform in seconds after emission, weights at bin centres.
inline double centroid_s(const std::vector<double>& row, const scene::LidarGate& gate) {
  double sum = 0;
  for (std::size_t i = 0; i < row.size(); ++i) sum += row[i] * (static_cast<double>(i) + 0.5);
  return gate.start_s + gate.bin_s * sum / row_sum(row);
}

}  // namespace raycube::test
