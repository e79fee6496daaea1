// How far from a LIDAR's platform anything lies that could send light back.
#pragma once

#include <array>

#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/lidar_spec.h"

namespace raycube::scene {

/// Ranges from the platform, m; farthest 0: nothing is there.
struct Reach {
  double nearest_m = 0, farthest_m = 0;
};

/// Of a scene's box (lo > hi: no surfaces) and of its volumes' boxes, over the whole trajectory: nothing lies
/// nearer or farther, though something nearest or farthest need not touch the box there. Ends of rays
/// (range_limit_m) cut it.
Reach reach_of(const std::array<float, 3>& lo, const std::array<float, 3>& hi, const std::vector<Volume>& volumes,
               const Lidar& lidar);

}  // namespace raycube::scene
