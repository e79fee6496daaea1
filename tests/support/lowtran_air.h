// Midlatitude summer as LOWTRAN7 has it: 33 of the 50 AFGL levels, densities from p / T.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "atmos_tables/optics/standard_air.h"

namespace raycube::testing {

/// With these gases; the others are left out.
inline atmos::AirProfile lowtran_air(const std::vector<atmos::Gas>& kept) {
  using namespace atmos;
  const AirProfile afgl = afgl_profile(AfglModel::midlatitude_summer);
  std::vector<AirLevel> levels;
  for (AirLevel level : afgl.levels()) {
    const double z = level.height_km;
    if (z > 25 && z != 30 && z != 35 && z != 40 && z != 45 && z != 50 && z != 70 && z != 100) continue;
    const double density = 2.68675e19 * (level.pressure_hPa / 1013.25) * (273.15 / level.temperature_K);
    for (std::size_t g = 0; g < kGases; ++g) {
      const bool keep = std::find(kept.begin(), kept.end(), static_cast<Gas>(g)) != kept.end();
      level.gas_per_cm3[g] *= keep ? density / level.air_per_cm3 : 0;
    }
    level.air_per_cm3 = density;
    levels.push_back(level);
  }
  return AirProfile(levels, "midlatitude summer, 33 levels");
}

/// With all of them.
inline atmos::AirProfile lowtran_air() {
  using atmos::Gas;
  return lowtran_air({Gas::h2o, Gas::co2, Gas::o3, Gas::n2o, Gas::co, Gas::ch4, Gas::o2});
}

}  // namespace raycube::testing
