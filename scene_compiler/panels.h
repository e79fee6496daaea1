// Analytic planes and boxes as triangles, in the scene frame.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "scene_compiler/bvh_builder.h"

namespace raycube::scene {

/// A rectangle cut into squares from its corner -x, -y; cell_m 0: one square. Corners of squares may be lifted.
struct Cut {
  double cell_m = 0;
  /// Surface of square (column, row), from 0 at that corner.
  std::function<std::uint32_t(std::uint32_t column, std::uint32_t row)> surface;
  /// How far off the rectangle a place lies, m, by its way from that corner, m; none: it is flat.
  std::function<double(double along_m, double up_m)> height_m = {};
};

/// Turns clockwise by yaw_deg seen from above: local +y points to azimuth yaw_deg.
std::array<double, 3> turned(const std::array<double, 3>& local, double yaw_deg);

/// Row-major 3 x 4: scale, turn, move.
std::array<double, 12> placement(const std::array<double, 3>& position_m, double yaw_deg, double scale);

/// A rectangle of size_m about position_m, its normal up, leaning by tilt_deg towards azimuth yaw_deg.
TriangleMesh plane_mesh(const std::array<double, 3>& position_m, const std::array<double, 2>& size_m, double yaw_deg,
                        double tilt_deg, const Cut& cut);

/// Faces of a box, in this order everywhere.
enum BoxFace { kTop, kBottom, kNorth, kSouth, kEast, kWest };
inline constexpr std::array<const char*, 6> kBoxFaceNames{"top", "bottom", "north", "south", "east", "west"};

/// A box standing with the centre of its base at position_m, faces outward, each cut from its lower left corner as one
/// sees it from outside (top and bottom: from the corner towards -y on the left, north up).
TriangleMesh box_mesh(const std::array<double, 3>& position_m, const std::array<double, 3>& size_m, double yaw_deg,
                      const std::array<Cut, 6>& faces);

}  // namespace raycube::scene
