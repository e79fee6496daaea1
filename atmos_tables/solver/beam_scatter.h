// Light scattered once from the beam, with the exact phase function along the scaled depth (TMS), and the
// small-angle correction of the higher orders in the aureole (IMS): Nakajima & Tanaka (1988), JQSRT 40, 51,
// eq. 22-25 and section 3.3.
#pragma once

#include <vector>

#include "atmos_tables/solver/beam_path.h"
#include "atmos_tables/solver/delta_m.h"
#include "atmos_tables/solver/user_radiance.h"

namespace raycube::atmos::solver {

/// A column's beam as the correction needs it.
struct BeamColumn {
  const Column* column = nullptr;  ///< its layers' exact phase functions
  const std::vector<ScaledLayer>* scaled = nullptr;
  const std::vector<BeamLayer>* beam = nullptr;  ///< along the scaled depth
  double flux = 0, cosine = 1;
  int streams = 16;
  bool exact_phase = true;  ///< TMS; false: the truncated phase function, consistent with the streams
};

/// Radiance scattered once into a direction of `cosine` up or down, at `place`. cos_angle: cosine of the
/// scattering angle.
double once_scattered(const BeamColumn& column, double cosine, bool up, double cos_angle, const Place& place);

/// IMS term, to be subtracted from downward radiance. 0 beyond 20 degrees of the beam (S4.6: small-angle
/// term) and where nothing was truncated above the place.
double aureole_excess(const BeamColumn& column, double cosine, double cos_angle, const Place& place);

}  // namespace raycube::atmos::solver
