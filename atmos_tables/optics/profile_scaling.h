// Profiles changed to what a user states: ground height and pressure, columns of water and ozone, mixing ratios.
#pragma once

#include <cstddef>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

/// Heights closer than half a metre are one: 350 m and 0.35 km may differ by rounding.
inline constexpr double kSameHeight_km = 0.0005;

/// The profile with a level added at a ground below its lowest one (at most 1 km below, else Error(input)):
/// temperature goes on with the gradient of the lowest kilometre, pressure and densities exponentially. A
/// ground inside it, or at its lowest level to half a metre: the profile as it is.
AirProfile extended_down(const AirProfile& profile, double ground_km);

/// The profile above a ground at this height, inside it or half a metre below; levels more than half a metre
/// above stay as they are.
AirProfile cut_at_ground(const AirProfile& profile, double ground_km);

/// Ground pressure set (300..1100 hPa): the hydrostatic change that leaves the temperatures alone is one factor on
/// pressures at every height. Air, CO2, N2O, CO, CH4 and O2 take it too, so their mixing ratios stay and the column of
/// air is proportional to the ground pressure; water and ozone keep their densities (their columns are stated by
/// themselves).
AirProfile with_ground_pressure(const AirProfile& profile, double pressure_hPa);

/// Saturation vapour pressure over water, hPa: 6.1094 exp(17.625 t / (t + 243.04)), t in C (Alduchov & Eskridge 1996).
double saturation_pressure_hPa(double temperature_K);
/// The same as molecules of water per cm3.
double saturation_per_cm3(double temperature_K);

struct WaterScaling {
  AirProfile profile;
  double factor = 1;  ///< on every level that was not capped
  std::size_t capped_levels =
      0;  ///< held at 100 % relative humidity, the cold trap's share, or the table's own value if higher
};
/// Water column set, g cm-2, by one factor with a cap at saturation. Throws Error(input) with the largest possible
/// column when the cap forbids it, or when the profile has no water.
WaterScaling with_water_column(const AirProfile& profile, double water_g_cm2);

/// Ozone column set, atm-cm (0..2), by one factor.
AirProfile with_ozone_column(const AirProfile& profile, double ozone_atm_cm);

/// Mixing ratio at the lowest level set, ppmv, by one factor: CO2, CH4 and other gases that are well mixed near the
/// ground.
AirProfile with_ground_mixing_ratio(const AirProfile& profile, Gas gas, double ppmv);

}  // namespace raycube::atmos
