// Light that a path emits, by the band model along the true path (atmosphere specification S2.5, S4.8): band models
// hold for whole paths, so what a layer sends to the observer is Planck's law times the fall of the transmission across
// the layer.
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/compiler/spectral_air.h"

namespace raycube::atmos {

/// How a layer radiates.
enum class LayerEmission {
  /// Planck radiance linear in optical depth between the layer's two edges: thick layers show the edge that faces the
  /// observer. Scattering takes light away and gives none.
  graded,
  /// LOWTRAN7's: the layer has one temperature, its mean by density, however thick it is; scattered light counts as
  /// absorbed, so
  /// 1 - T is the emissivity. In opaque bands a layer of 1 km is off by 5 (6 um) to 15 % (2.6 um). For comparisons.
  one_temperature
};

/// Radiance, W m-2 sr-1 um-1, that the air between two levels sends along a ray with these path factors to an observer
/// at the upper or the lower of them.
double path_emission(const SpectralAir& air, const AirStack& stack, const std::vector<double>& path_factor,
                     std::size_t low, std::size_t high, bool observer_above, LayerEmission rule);

/// The same in the plane-parallel column of one k-term, graded, at a cosine (0, 1] of the zenith angle: what the
/// solver's radiance has beyond it is thermal light scattered into the path.
double term_emission(const SpectralAir& air, const AirStack& stack, std::size_t term, double cosine, std::size_t low,
                     std::size_t high, bool observer_above);

}  // namespace raycube::atmos
