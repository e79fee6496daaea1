// Textures: an image says which spectrum of a material's family lies where ([A] 1.1.8: the curve as many standard
// deviations from its family's mean, in the image's band, as the texel is from the image's mean; docs/scene_format.md),
// and masks: an image says where there is something at all.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/document.h"
#include "scene_compiler/band_values.h"

namespace raycube::scene {

struct Raster;
/// Bands of the image that a record of `image` and `band` names, whole; nullopt after reporting. made_bytes: what the
/// caller makes of a texel while it holds them.
std::optional<Raster> read_image(const Record& record, int bands, double made_bytes, base::Problems& problems);

/// A number for each texel of an image that repeats without end: of a texture the member of a family, from 0, of a mask
/// 1 where there is something.
class Texture {
 public:
  /// numbers: row by row from the image's first row, which is the uppermost. texel_m 0: it lies by texture coordinates.
  Texture(int columns, int rows, double texel_m, std::vector<std::uint16_t> numbers);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double texel_m() const { return texel_m_; }
  bool by_coordinates() const { return texel_m_ == 0; }
  /// Number at a place: u to the right of the image's lower left corner, v above it, in m or, by texture coordinates,
  /// in images.
  std::uint32_t at(double u, double v) const;

 private:
  int columns_, rows_;
  double texel_m_;
  std::vector<std::uint16_t> numbers_;
};

enum class TexelChoice {
  rank,       ///< members by brightness share the texels by brightness evenly: mean and covariance are the family's
  deviations  ///< [A]: the member nearest mean + z sd of the band, z the texel's own deviation in the image
};

/// Member of each texel by its brightness. brightness: of each member, in the image's band. Of equal texels chance
/// decides by rank; a brighter texel never has a darker member.
std::vector<std::uint16_t> choose_members(const BandValues& texels, const std::vector<double>& brightness,
                                          TexelChoice choice);

/// Member of each texel whose reflectances are nearest, by squares; of several the first. bands: of each the texels'
/// values, `white` those of reflectance 1; means: of each band, of each member.
std::vector<std::uint16_t> nearest_members(const std::vector<BandValues>& bands, double white,
                                           const std::vector<std::vector<double>>& means);

/// Mean of a curve from one wavelength to another, um, by trapezoids over its own points.
double mean_between(const Curve& curve, double from_um, double to_um);

/// [material.texture] of a material whose family is `members`; nullopt after reporting.
std::optional<Texture> read_texture(const Record& texture, const std::vector<Material>& members,
                                    base::Problems& problems);

/// [material.mask]; nullopt after reporting.
std::optional<Texture> read_mask(const Record& mask, base::Problems& problems);

}  // namespace raycube::scene
