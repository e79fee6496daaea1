// Delta-M: the forward peak of the phase function counts as light not scattered at all (atmosphere
// specification S4.6).
#pragma once

#include <vector>

#include "atmos_tables/solver/column.h"

namespace raycube::atmos::solver {

/// A layer as the discrete ordinates see it. Primed quantities of Wiscombe (1977), eq. 17-20.
struct ScaledLayer {
  double depth = 0;            ///< (1 - omega f) tau
  double albedo = 0;           ///< omega (1 - f) / (1 - omega f)
  std::vector<double> moment;  ///< (chi_k - f) / (1 - f), k < streams (zeros beyond the last given)
  double true_depth = 0;       ///< tau
  double true_albedo = 0;      ///< omega, clamped to [0, 1]
  double truncation = 0;       ///< f = chi_streams; 0 without delta-M
  double source_albedo =
      0;  ///< omega / (1 - omega f): strength of the exact single scattering along the scaled depth (TMS)
};

/// A phase function that is a forward delta (f = 1) becomes a layer without scattering.
ScaledLayer scale_layer(const Layer& layer, int streams, bool delta_m);

}  // namespace raycube::atmos::solver
