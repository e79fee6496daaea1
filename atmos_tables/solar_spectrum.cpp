#include "atmos_tables/solar_spectrum.h"

#include <algorithm>
#include <iterator>

namespace raycube::atmos {

namespace {
struct Node {
  double wavelength_nm, irradiance;
};
constexpr Node kNodes[] = {
#include "atmos_tables/data/solar_tsis1_gueymard.inc"
};
}  // namespace

double solar_irradiance_1au(double wavelength_um) {
  const double nm = 1000 * wavelength_um;
  const Node* upper = std::upper_bound(std::begin(kNodes) + 1, std::end(kNodes) - 1, nm,
                                       [](double value, const Node& node) { return value < node.wavelength_nm; });
  const Node &a = upper[-1], &b = *upper;
  const double w = (nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm);
  return (1 - w) * a.irradiance + w * b.irradiance;
}

std::string solar_source_name() { return "TSIS-1 HSRS (Coddington 2021) 0.35-2.5 um, Gueymard 2004 outside; averages over 2 nm to 500 nm"; }

}  // namespace raycube::atmos
