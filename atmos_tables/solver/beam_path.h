// How the beam fades on its way down: plane-parallel, or along straight slant paths through spherical shells.
#pragma once

#include <vector>

#include "atmos_tables/solver/column.h"

namespace raycube::atmos::solver {

/// Beam inside one layer: transmittance = top * exp(-slope * u), u the vertical optical depth below the
/// layer's top.
struct BeamLayer {
  double top = 1;    ///< transmittance from space to the layer's top
  double slope = 1;  ///< slant depth per vertical depth, >= 1e-6; 1/cosine when plane-parallel
};

/// depth: vertical optical depth of each layer (scaled or not). With level heights the slant depth to each
/// level is the sum of layer depth times chord length over thickness (Dahlback & Stamnes 1991, Planet. Space
/// Sci. 39, 671, appendix B), refraction left out. Where the slant depth falls with depth (thin layer under
/// thick ones, low sun) the layer's mean is used. Cosines below 1e-9 count as 1e-9.
std::vector<BeamLayer> beam_through_layers(const Column& column, const std::vector<double>& depth);

}  // namespace raycube::atmos::solver
