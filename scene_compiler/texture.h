// Textures: an image says which spectrum of a material's family lies where ([A] 1.1.8: the curve as many standard
// deviations from its family's mean, in the image's band, as the texel is from the image's mean; docs/scene_format.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/document.h"

namespace raycube::scene {

/// Which member of a family each texel has. The image repeats without end.
class Texture {
 public:
  /// member: row by row from the image's first row, which is the uppermost.
  Texture(int columns, int rows, double texel_m, std::vector<std::uint16_t> member);

  double texel_m() const { return texel_m_; }
  /// Member, from 0, at a place: u_m to the right of the image's lower left corner, v_m above it, m.
  std::uint32_t member(double u_m, double v_m) const;

 private:
  int columns_, rows_;
  double texel_m_;
  std::vector<std::uint16_t> member_;
};

enum class TexelChoice {
  rank,       ///< members by brightness share the texels by brightness evenly: mean and covariance are the family's
  deviations  ///< [A]: the member nearest mean + z sd of the band, z the texel's own deviation in the image
};

/// Member of each texel. brightness: of each member, in the image's band. Of equal texels chance decides by rank; a
/// brighter texel never has a darker member.
std::vector<std::uint16_t> choose_members(const std::vector<double>& texels, const std::vector<double>& brightness,
                                          TexelChoice choice);

/// Mean of a curve from one wavelength to another, um, by trapezoids over its own points.
double mean_between(const Curve& curve, double from_um, double to_um);

/// [material.texture] of a material whose family is `members`; nullopt after reporting.
std::optional<Texture> read_texture(const Record& texture, const std::vector<Material>& members,
                                    base::Problems& problems);

}  // namespace raycube::scene
