// Polygons to triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace raycube::scene {

/// Ear clipping of a simple polygon in its best plane (Newell normal), in double; corners in order,
/// counter-clockwise or not. Returns corner indices, n - 2 triangles with the polygon's orientation. A
/// polygon that is not simple (crossing or repeated corners) still gives n - 2 triangles; those of zero area
/// are for the caller to drop.
std::vector<std::array<std::uint32_t, 3>> triangulate_polygon(std::span<const std::array<double, 3>> corners);

}  // namespace raycube::scene
