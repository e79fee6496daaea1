// Direction sets towards the sky: low-discrepancy points over the hemisphere, shifted and turned from set to set.
#pragma once

#include <cstdint>

#include "host/plan/plan.h"

namespace raycube::plan {

inline constexpr int kMostDirections = 4096;

/// Sets of `directions` unit vectors (1 .. kMostDirections). Each estimates integral of A_m max(0, n.d) dOmega without bias over the sets.
/// sun_azimuth_rad: where the maps' azimuth 0 lies, clockwise from north.
SkySets make_sky_sets(const SkyBasis& basis, double sun_azimuth_rad, int directions, std::uint64_t seed);

}  // namespace raycube::plan
