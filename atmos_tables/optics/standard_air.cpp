#include "atmos_tables/optics/standard_air.h"

#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

/// Heights, and the two gases that do not differ between the models.
struct CommonRow {
  double height_km, co2_ppmv, o2_ppmv;
};
struct ModelRow {
  double pressure_hPa, temperature_K, air_per_cm3, h2o_ppmv, o3_ppmv, n2o_ppmv, co_ppmv, ch4_ppmv;
};
#include "atmos_tables/optics/data/afgl_1986.inc"

}  // namespace

StandardAir us_standard_1976(double height_km) {
  if (!(height_km >= -5 && height_km <= 80))
    throw base::Error(base::Fault::input, "US Standard Atmosphere 1976: the formulas cover -5 to 80 km (found " +
                                              std::to_string(height_km) + " km); use an AFGL profile above");
  // Base of each layer in geopotential km, and its gradient of temperature, K per km (Table 4).
  constexpr double base_km[] = {0, 11, 20, 32, 47, 51, 71}, gradient[] = {-6.5, 0, 1, 2.8, 0, -2.8, -2};
  // Constants of the 1976 report: g0 M0 / R* in K per km, Avogadro / R* in molecules per (J K-1).
  constexpr double radius_km = 6356.766, hydrostatic = 9.80665 * 28.9644 / 8.31432;
  constexpr double avogadro = 6.022169e26, gas_constant = 8.31432e3;
  const double geopotential_km = radius_km * height_km / (radius_km + height_km);
  StandardAir out{1013.25, 288.15, 0};
  for (std::size_t i = 0; i < std::size(base_km); ++i) {
    const bool last = i + 1 == std::size(base_km) || geopotential_km < base_km[i + 1];
    const double step = (last ? geopotential_km : base_km[i + 1]) - base_km[i],
                 end_K = out.temperature_K + gradient[i] * step;
    out.pressure_hPa *= gradient[i] == 0 ? std::exp(-hydrostatic * step / out.temperature_K)
                                         : std::pow(out.temperature_K / end_K, hydrostatic / gradient[i]);
    out.temperature_K = end_K;
    if (last) break;
  }
  out.air_per_cm3 = 1e-6 * avogadro * 100 * out.pressure_hPa / (gas_constant * out.temperature_K);
  return out;
}

AirProfile afgl_profile(AfglModel model) {
  const std::size_t index = static_cast<std::size_t>(model);
  std::vector<AirLevel> levels;
  for (std::size_t i = 0; i < std::size(kCommon); ++i) {
    const CommonRow& common = kCommon[i];
    const ModelRow& row = kModels[index][i];
    const double per_ppmv = 1e-6 * row.air_per_cm3;
    AirLevel level{common.height_km, row.pressure_hPa, row.temperature_K, row.air_per_cm3, {}};
    level.gas(Gas::h2o) = per_ppmv * row.h2o_ppmv, level.gas(Gas::co2) = per_ppmv * common.co2_ppmv;
    level.gas(Gas::o3) = per_ppmv * row.o3_ppmv, level.gas(Gas::n2o) = per_ppmv * row.n2o_ppmv;
    level.gas(Gas::co) = per_ppmv * row.co_ppmv, level.gas(Gas::ch4) = per_ppmv * row.ch4_ppmv;
    level.gas(Gas::o2) = per_ppmv * common.o2_ppmv;
    levels.push_back(level);
  }
  return AirProfile(std::move(levels), std::string("AFGL 1986 ") + kAfglNames[index]);
}

}  // namespace raycube::atmos
