// Orientation of an instrument in the scene frame (docs/conventions.md, "Platform"). Double throughout.
#pragma once

#include <glm/vec3.hpp>

#include "scene_compiler/simulation.h"

namespace raycube::sensors {

/// Where an instrument is and how it is turned: orthonormal axes of the platform in the scene frame (x east, y north, z
/// up).
struct CameraFrame {
  glm::dvec3 origin_m{0};
  glm::dvec3 forward{0, 1, 0};     ///< nose
  glm::dvec3 right{1, 0, 0};       ///< right wing
  glm::dvec3 boresight{0, 0, -1};  ///< optical axis, the platform's "down"
};

/// Frame of one pose: forward-right-down axes turned by yaw, pitch, roll (z-y-x, intrinsic), then north-east-down to
/// east-north-up.
CameraFrame frame_of(const scene::Pose& pose);

/// Pose between two: position linear, rotation by spherical linear interpolation (Shoemake 1985). fraction 0 gives
/// `from`,
/// 1 gives `to`; values outside extrapolate at constant rate (S10).
CameraFrame interpolate(const scene::Pose& from, const scene::Pose& to, double fraction);

}  // namespace raycube::sensors
