// Path of a ray in layers of refracting spherical air, per thickness of the layer.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::testing {

/// Bouguer: n r sin(zenith) is constant; n - 1 = 2.92e-4 in air of 1013.25 hPa and 273.15 K (S4.2: good enough for
/// paths), earth of 6371.23 km. Midpoint rule, 40 points a layer. zenith_deg: of the ray, 0..85 upward or 95..180
/// downward, at the height at_km.
inline std::vector<double> curved_path_factors(const atmos::AirProfile& profile, const std::vector<double>& level_km,
                                               double zenith_deg, double at_km) {
  const auto reach = [&](double height_km) {
    const atmos::AirLevel air = profile.at(height_km);
    return (6371.23 + height_km) * (1 + 2.92e-4 * (air.pressure_hPa / 1013.25) * (273.15 / air.temperature_K));
  };
  const double constant = reach(at_km) * std::sin(zenith_deg * 3.14159265358979 / 180);
  constexpr int points = 40;
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < level_km.size(); ++i) {
    double sum = 0;
    for (int k = 0; k < points; ++k) {
      const double sine = constant / reach(level_km[i] + (k + 0.5) / points * (level_km[i + 1] - level_km[i]));
      sum += 1 / std::sqrt(1 - sine * sine) / points;
    }
    out.push_back(sum);
  }
  return out;
}

}  // namespace raycube::testing
