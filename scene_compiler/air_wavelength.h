// Wavelengths in air to wavelengths in vacuum, once, at the border.
#pragma once

namespace raycube::scene {

/// Refractive index of standard air (dry, 15 deg C, 101325 Pa, 450 ppm CO2); wavelength_um is the
/// vacuum wavelength, valid 0.23 to 1.69 um to 1e-8; above, the formula tends to its infrared limit (n - 1
/// = 2.73e-4, good to about 1e-7 outside absorption bands); below 0.2 um, where wavelengths are quoted in
/// vacuum, it gives 1. Ciddor 1996, Applied Optics 35(9), 1566, equation (1).
double ciddor_air_index(double wavelength_um);

/// Vacuum wavelength of a wavelength measured in standard air: lambda_vac = n(lambda_vac) lambda_air, by
/// fixed-point iteration (converged to the last bit: n changes by 1e-6 of the step).
double vacuum_from_air_um(double air_wavelength_um);

}  // namespace raycube::scene
