// Scenes that geometry tests and tuning generate, all from closed formulas and a counter hash.
#pragma once

#include <array>
#include <cstdint>

#include "scene_compiler/bvh_builder.h"

namespace raycube::test {

/// Identity as append_instance wants it.
inline constexpr std::array<double, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// Uniform in [0, 1) from a counter.
double unit_random(std::uint32_t seed, std::uint32_t index, std::uint32_t dimension);

/// Row-major 3 x 4: rotation about z by `yaw` (rad), then about x by `tilt`, scale, then translation (m).
std::array<double, 12> placement(double yaw, double tilt, double scale, double x, double y, double z);

/// Height field of cells x cells quads (two triangles each) over size x size m, centred on the origin, hills of a few
/// m.
scene::TriangleMesh terrain(int cells, double size);

/// Closed sphere: an icosahedron split `levels` times (20 * 4^levels triangles), radius m, bumps of `bump` * radius.
scene::TriangleMesh sphere(int levels, double radius, double bump);

/// `leaves` square leaves (two triangles each) of `edge` m, uniform in a ball of `radius` and over orientation.
scene::TriangleMesh crown(int leaves, double edge, double radius, std::uint32_t seed);

/// `count` triangles with corners anywhere in a cube of half edge `half`, of size up to `size`.
scene::TriangleMesh triangle_soup(int count, double half, double size, std::uint32_t seed);

/// The painted lines of the park's basketball courts: 15 x 28 m, 7 cm wide, flat at z = 0, in the order of scenes/park.
scene::TriangleMesh court_lines();

/// One mesh, placed once without moving it, top tree built.
scene::CompiledScene single(const scene::TriangleMesh& mesh);

}  // namespace raycube::test
