// Molecular scattering of dry air with 360 ppm CO2. Wavelength vacuum, um, 0.2..4.
#pragma once

namespace raycube::atmos {

/// Vertical optical depth from sea level at 45 degrees latitude, scaled by pressure: Bodhaine et al. (1999), J. Atmos.
/// Oceanic Technol. 16, 1854-1861, eq. 30: 0.0021520 (1.0455996 - 341.29061 l^-2 - 0.90230850 l^2) /
/// (1 + 0.0027059889 l^-2 - 85.968563 l^2). 0.0971 at 0.55 um and 1013.25 hPa.
double rayleigh_depth(double wavelength_um, double pressure_hPa);

/// Depolarisation factor rho from the King factor of air (Bodhaine et al. 1999, eq. 5-6 and Table 1): F =
/// (6+3rho)/(6-7rho).
double rayleigh_depolarization(double wavelength_um);

/// Phase function, integral over the sphere 4 pi: 3/(4(1+2g)) ((1+3g) + (1-g) cos^2), g = rho/(2-rho) (Chandrasekhar).
double phase_rayleigh(double depolarization, double cos_angle);

}  // namespace raycube::atmos
