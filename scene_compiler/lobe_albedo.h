// How much of an even light a scattering shape sends towards one direction: what a surface's emission lacks there, by
// Kirchhoff's law, of what a black body would send.
#pragma once

#include <span>
#include <vector>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// Hemispherical-directional reflectance factor of a shape for a curve of 1: integral of f cos over the directions that
/// light comes from (Nicodemus et al., NBS Monograph 160, 1977). direction: unit, to where it goes, x east and y north
/// on the surface (RcAngles), z > 0 its normal. 1 by Lambert's law. By midpoints, half of them drawn by the shape and
/// half by the cosine, weighed by both densities (Veach & Guibas 1995): to 3e-4, 1.5e-3 of the narrowest shapes (test
/// `lobe_albedo`).
double lobe_albedo(const Shape& shape, const RcLocal& direction);

/// Its mean over the hemisphere of directions, weighed by their cosine: the share of an even light that leaves.
double mean_lobe_albedo(const Shape& shape);

/// Linear between nodes of the zenith angle, evenly from 0 to pi / 2, and of the azimuth, 0 to pi: what is turned half
/// round is the same. nodes: [azimuth][zenith].
double between_albedos(std::span<const float> nodes, int zeniths, int azimuths, const RcLocal& direction);

/// lobe_albedo at such nodes.
class LobeAlbedo {
 public:
  LobeAlbedo(const Shape& shape, int zeniths, int azimuths);
  double at(const RcLocal& direction) const { return between_albedos(value_, zeniths_, azimuths_, direction); }
  std::span<const float> nodes() const { return value_; }  ///< [azimuth][zenith]

 private:
  int zeniths_, azimuths_;
  std::vector<float> value_;
};

}  // namespace raycube::scene
