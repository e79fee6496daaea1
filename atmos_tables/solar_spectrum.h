// The sun's spectrum above the air at 1 AU, 0.3 to 31 um: TSIS-1 (Coddington et al. 2021) from 0.35 to 2.5
// um, Gueymard (2004) outside, scaled to TSIS-1 at the joints; restated at 2 nm to 500 nm
// (data/solar_tsis1_gueymard.inc). Beyond, Planck's law of 5000 K.
#pragma once

#include <string>

namespace raycube::atmos {

/// W m-2 um-1, linear between nodes; the wavelength (vacuum) must not lie below 0.3 um.
double solar_irradiance_1au(double wavelength_um);
/// Its mean over [from, to] um; what of it lies outside 0.3..31 um counts as the nearest end.
double mean_solar_irradiance_1au(double from_um, double to_um);
/// Short name of the source, for a table's header.
std::string solar_source_name();

}  // namespace raycube::atmos
