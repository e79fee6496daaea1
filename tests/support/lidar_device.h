// One call from plan and shots to results on the device.
#pragma once

#include <vector>

#include "host/render/lidar_renderer.h"
#include "tests/support/kept_programs.h"

namespace raycube::test {

inline std::vector<lidar::ShotResult> render_shots(const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                                                   const std::vector<lidar::Shot>& shots,
                                                   const render::RenderOptions& options = {}, bool hits = false) {
  render::LidarRenderer renderer(scene, options);
  std::vector<lidar::ShotResult> results;
  renderer.render(
      plan, shots, [&](lidar::ShotResult&& result) { results.push_back(std::move(result)); }, hits);
  return results;
}

}  // namespace raycube::test
