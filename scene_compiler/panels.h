// Analytic planes and boxes as triangles, in the scene frame.
#pragma once

#include <array>
#include <cstdint>

#include "scene_compiler/bvh_builder.h"

namespace raycube::scene {

/// Surface of a square by parity: cells (0, 0) at the corner -x, -y has surface[0]. cell_m 0: one square,
/// surface[0].
struct Checker {
  std::array<std::uint32_t, 2> surface{};
  double cell_m = 0;
};

/// Turns clockwise by yaw_deg seen from above: local +y points to azimuth yaw_deg.
std::array<double, 3> turned(const std::array<double, 3>& local, double yaw_deg);

/// Row-major 3 x 4: scale, turn, move.
std::array<double, 12> placement(const std::array<double, 3>& position_m, double yaw_deg, double scale);

/// A rectangle of size_m about position_m, its normal up, leaning by tilt_deg towards azimuth yaw_deg.
TriangleMesh plane_mesh(const std::array<double, 3>& position_m, const std::array<double, 2>& size_m, double yaw_deg,
                        double tilt_deg, const Checker& checker);

/// Faces of a box, in this order everywhere.
enum BoxFace { kTop, kBottom, kNorth, kSouth, kEast, kWest };
inline constexpr std::array<const char*, 6> kBoxFaceNames{"top", "bottom", "north", "south", "east", "west"};

/// A box standing with the centre of its base at position_m, faces outward. top: squares of the top face;
/// surface[kTop] is not used.
TriangleMesh box_mesh(const std::array<double, 3>& position_m, const std::array<double, 3>& size_m, double yaw_deg,
                      const std::array<std::uint32_t, 6>& surface, const Checker& top);

}  // namespace raycube::scene
