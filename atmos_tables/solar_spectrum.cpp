#include "atmos_tables/solar_spectrum.h"

#include <algorithm>
#include <iterator>

#include "host/base/planck.h"

namespace raycube::atmos {

namespace {
struct SolarNode {
  double wavelength_nm, irradiance;
};
constexpr SolarNode kSolarNodes[] = {
#include "atmos_tables/data/solar_tsis1_gueymard.inc"
};
constexpr double kFarKelvin = 5000;  ///< brightness temperature of the sun's far infrared, good to 10 % to 1000 um
}  // namespace

double solar_irradiance_1au(double wavelength_um) {
  const double nm = 1000 * wavelength_um;
  if (const SolarNode& last = std::end(kSolarNodes)[-1]; nm > last.wavelength_nm)
    return last.irradiance * base::planck_radiance(wavelength_um, kFarKelvin) /
           base::planck_radiance(last.wavelength_nm / 1000, kFarKelvin);
  const SolarNode* upper =
      std::upper_bound(std::begin(kSolarNodes) + 1, std::end(kSolarNodes) - 1, nm,
                       [](double value, const SolarNode& node) { return value < node.wavelength_nm; });
  const SolarNode &a = upper[-1], &b = *upper;
  const double w = (nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm);
  return (1 - w) * a.irradiance + w * b.irradiance;
}

double mean_solar_irradiance_1au(double from_um, double to_um) {
  const double first = std::begin(kSolarNodes)->wavelength_nm / 1000,
               last = (std::end(kSolarNodes) - 1)->wavelength_nm / 1000;
  const auto value = [&](double um) { return solar_irradiance_1au(std::clamp(um, first, last)); };
  if (!(to_um > from_um)) return value(from_um);
  double sum = 0, at = from_um, here = value(from_um);
  const auto advance = [&](double um) {
    const double next = value(um);
    sum += 0.5 * (here + next) * (um - at);
    at = um, here = next;
  };
  for (const SolarNode* node = std::begin(kSolarNodes); node != std::end(kSolarNodes); ++node)
    if (const double um = node->wavelength_nm / 1000; um > from_um && um < to_um) advance(um);
  advance(to_um);
  return sum / (to_um - from_um);
}

std::string solar_source_name() {
  return "TSIS-1 HSRS (Coddington 2021) 0.35-2.5 um, Gueymard 2004 outside; averages over 2 nm to 500 nm";
}

}  // namespace raycube::atmos
