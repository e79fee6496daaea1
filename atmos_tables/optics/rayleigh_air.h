// Scattering by the molecules of dry air from first principles: Bodhaine, Wood, Dutton & Slusser (1999), J. Atmos.
// Oceanic Technol. 16, 1854-1861, with the King factors of Bates (1984), Planet. Space Sci. 32, 785-790. Wavelength
// vacuum, um, 0.23..30 (the refractive index is measured to 1.7 um and smooth beyond). CO2 as ppmv of dry air. Scalar:
// no polarisation.
#pragma once

#include <vector>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

/// n - 1 at 288.15 K and 1013.25 hPa: Peck & Reeder (1972) for 300 ppmv, times 1 + 0.54 (c - 0.0003) (Bodhaine eq.
/// 18-19).
double air_refractivity(double wavelength_um, double co2_ppmv);

/// F = (6 + 3 rho) / (6 - 7 rho), mean over N2, O2, Ar, CO2 by volume (Bodhaine eq. 5, 6 and 23). 1.0488 at 0.55 um.
double air_king_factor(double wavelength_um, double co2_ppmv);

/// rho of unpolarised light, from the King factor.
double air_depolarization(double wavelength_um, double co2_ppmv);

/// Scattering cross-section of a molecule, cm2: 24 pi^3 (n^2 - 1)^2 F / (l^4 N^2 (n^2 + 2)^2), N = 2.546899e19 cm-3
/// (eq. 22).
double rayleigh_cross_section_cm2(double wavelength_um, double co2_ppmv);

/// Moments chi_0..chi_2 of the phase function phase_rayleigh (rayleigh.h): 1, 0, 0.1 (1 - rho) / (1 + rho / 2).
std::vector<double> rayleigh_moments(double depolarization);

/// Vertical optical depth of the air above a height of the profile, what lies beyond its top included.
double rayleigh_depth_above(const AirProfile& profile, double height_km, double wavelength_um);

}  // namespace raycube::atmos
