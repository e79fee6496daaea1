// Triangles cut along the texels of images that lie by texture coordinates.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace raycube::scene {

/// A corner of a piece: its place in the mesh's frame, m, and in images: u to the right of one's lower left corner, v
/// above it.
struct ImageCorner {
  std::array<double, 3> position{};
  std::array<double, 2> in_image{};
};

/// Texels of an image along u and v; of several images each.
using TexelCounts = std::array<std::vector<int>, 2>;

/// Cells into which the texels' edges cut the rectangle about a triangle, before anything is done.
double texel_cells(const std::array<ImageCorner, 3>& triangle, const TexelCounts& counts);

/// Hands out the convex pieces of a triangle, corners in its order, each with what `of` says of the texel (u, v) at its
/// middle: texel by texel, neighbours meeting corner to corner, or, if `join`, equal ones together, as halving finds
/// them. Cuts are made in double; pieces may be as thin as rounding makes them.
void cut_by_texels(const std::array<ImageCorner, 3>& triangle, const TexelCounts& counts, bool join,
                   const std::function<std::uint32_t(double u, double v)>& of,
                   const std::function<void(const std::vector<ImageCorner>& piece, std::uint32_t number)>& take);

}  // namespace raycube::scene
