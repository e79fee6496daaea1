// Radiance in any direction: the discrete-ordinate source function integrated along the line of sight
// (Stamnes et al. 1988, section II.F). The light scattered once from the beam is left out here;
// beam_scatter.h adds it with the exact phase function.
#pragma once

#include <array>
#include <vector>

#include "atmos_tables/solver/layer_modes.h"

namespace raycube::atmos::solver {

/// A place in the column.
struct Place {
  std::size_t layer = 0;  ///< index; 0 in a column without layers
  double u = 0;           ///< scaled optical depth below the layer's top
};

/// One azimuth order of the solved column. Cases: 0 the column's own light over a black, cold ground; 1
/// (order 0 only) unit isotropic radiance from the ground and no other source.
struct OrderSolution {
  int order = 0;
  int cases = 1;
  std::vector<LayerMode> layers;
  std::vector<std::vector<Amplitudes>> amplitudes;  ///< [case][layer]
};

/// Radiance of both cases (the second 0 unless order 0) that travels at `cosine` up or down past `place`,
/// without the beam's first scattering and without the azimuth factor cos(order * azimuth). top_radiance:
/// isotropic light from above.
std::array<double, 2> order_radiance(const OrderSolution& solution, const std::vector<ScaledLayer>& scaled,
                                     const HalfRange& nodes, int streams, double cosine, bool up,
                                     const Place& place, double top_radiance);

}  // namespace raycube::atmos::solver
