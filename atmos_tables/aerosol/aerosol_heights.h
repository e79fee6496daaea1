// Height profiles of LOWTRAN7's four aerosol regions for a visibility, and the visibility for an optical depth.
//
// Boundary layer 0-2 km, troposphere 2-10, stratosphere 10-30, upper air above; neighbours overlap over one step of the
// tables, where one falls linearly to 0 and the next rises (as LOWTRAN7 does: zero at the other's first level).
// Extinction is linear in
// 1 / visibility between the tabulated visibilities and beyond them. Above a ground at height zg, heights below 6 km
// above the sea are compressed, z' = zg + z (6 - zg) / 6 (LOWTRAN7, MODTRAN), extinctions stay.
#pragma once

#include <array>
#include <cstddef>

#include "atmos_tables/aerosol/aerosol_spec.h"
#include "atmos_tables/aerosol/height_profile.h"

namespace raycube::atmos {

/// Where the extrapolation to clear air reaches no aerosol at 2 km: 323.58 km, MODTRAN's limit too.
double max_visibility_km();
inline constexpr double kMinVisibility_km = 0.02, kMaxAerosolGround_km = 5.5;

/// Koschmieder's law with 2 % contrast, less Rayleigh extinction at 0.55 um: 3.912 / V - 0.01159 km-1.
double koschmieder_extinction_per_km(double visibility_km);

using AerosolHeights = std::array<HeightProfile, 4>;
/// Regions for a visibility in [kMinVisibility_km, max_visibility_km()].
AerosolHeights aerosol_heights(double visibility_km, bool spring_summer, StratosphereModel stratosphere,
                               double ground_km);
double total_depth(const AerosolHeights& heights);

/// The visibility whose regions have this optical depth at 0.55 um together. Below the least possible depth: the
/// clearest air. Throws Error(input) above what kMinVisibility_km gives.
double visibility_for_depth_km(double depth_550, bool spring_summer, StratosphereModel stratosphere, double ground_km);

}  // namespace raycube::atmos
