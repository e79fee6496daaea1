// Relief of surfaces: an image of heights, or of the normals of such heights, lifts what a material covers off its own
// plane ([A] 1.1.8: bump maps and normal maps; docs/scene_format.md). It becomes triangles, so that shadows, masking
// and pulses know it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "scene_compiler/document.h"

namespace raycube::scene {

/// Heights at the middles of the texels of an image that repeats without end, linear between them.
class Relief {
 public:
  /// height: of texels, row by row from the image's first row, which is the uppermost: m, or, by texture coordinates
  /// and of normals, sides of a texel. texel_m 0: it lies by texture coordinates.
  Relief(int columns, int rows, double texel_m, bool in_texels, std::function<double(std::size_t)> height);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double texel_m() const { return texel_m_; }
  bool by_coordinates() const { return texel_m_ == 0; }
  bool in_texels() const { return in_texels_; }
  /// Height at a place, u to the right of the image's lower left corner, v above it: in m, or in images where it lies
  /// by texture coordinates.
  double at(double u, double v) const;

 private:
  int columns_, rows_;
  double texel_m_;
  bool in_texels_;
  std::function<double(std::size_t)> height_;  ///< from the image's own numbers, which are smaller than heights
};

/// Per texel.
struct Slope {
  double to_right = 0, up = 0;
};

/// Heights whose slopes are nearest to these by least squares, over an image that repeats, of mean 0: Frankot and
/// Chellappa, IEEE Trans. PAMI 10(4), 1988, equation 21. Slopes of texels row by row from the uppermost; heights in
/// texels. A mean slope, which no image that repeats can have, and any swirl are left out. Exact for heights without
/// waves of two texels.
std::vector<double> heights_of_slopes(int columns, int rows, const std::function<Slope(std::size_t)>& slope);

/// [material.bump] or [material.normals]; nullopt where a material has neither, or after reporting.
std::optional<Relief> read_relief(const Record& material, base::Problems& problems);

}  // namespace raycube::scene
