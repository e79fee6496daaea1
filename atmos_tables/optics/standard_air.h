// Built-in air: the US Standard Atmosphere 1976 from its formulas, and the six AFGL model atmospheres (1986).
#pragma once

#include <array>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

struct StandardAir {
  double pressure_hPa = 0, temperature_K = 0, air_per_cm3 = 0;
};

/// US Standard Atmosphere 1976 (NOAA-S/T 76-1562), eq. 18, 23, 33a-b, dry air; geometric height -5..80 km (to 80 km the
/// molecular mass is that of the ground). Throws Error(input) outside.
StandardAir us_standard_1976(double height_km);

/// Anderson, Clough, Kneizys, Chetwynd & Shettle (1986), AFGL-TR-86-0110: 50 levels to 120 km with seven gases; CO2 330
/// ppmv.
enum class AfglModel {
  tropical,
  midlatitude_summer,
  midlatitude_winter,
  subarctic_summer,
  subarctic_winter,
  us_standard
};
inline constexpr std::array<const char*, 6> kAfglNames = {
    "tropical", "midlatitude_summer", "midlatitude_winter", "subarctic_summer", "subarctic_winter", "us_standard"};
AirProfile afgl_profile(AfglModel model);

}  // namespace raycube::atmos
