// Planck's law with the exact constants of the SI of 2019 (h = 6.62607015e-34 J s, k = 1.380649e-23 J/K, c = 299792458
// m/s).
#pragma once

#include <cmath>

namespace raycube::base {

/// Tables that reach this far say what the air emits, and scenes seen there say how warm every surface is: a
/// black body of 300 K emits a tenth of what a surface of reflectance 0.1 sends back of the sun at 45 degrees
/// (without air: 0.097), at 2.5 um 0.5 %, at 2.2 um 0.04 %. Below, thermal light is rendered where it can be
/// seen.
inline constexpr double kHeatFrom_um = 3.0;
/// Whether wavelengths up to this one need what surfaces and air emit. A table that ends at 3 um, computed on
/// wavenumbers, may end a last digit beyond it.
inline bool asks_for_heat(double last_um) { return last_um > kHeatFrom_um * (1 + 1e-6); }

inline constexpr double kFirstRadiationConstant = 1.191042972397188e8;  ///< 2 h c^2, W m-2 sr-1 um4
inline constexpr double kSecondRadiationConstant = 14387.768775039337;  ///< h c / k, um K

/// Radiance of a black body, W m-2 sr-1 um-1: B = 2 h c^2 / (l^5 (exp(h c / (l k T)) - 1)). wavelength_um > 0; 0 at and
/// below
/// 0 K. Finite everywhere: where exp overflows (l T below 20 um K) the radiance is 0 in double anyway.
inline double planck_radiance(double wavelength_um, double temperature_K) {
  if (!(temperature_K > 0)) return 0;
  const double x = kSecondRadiationConstant / (wavelength_um * temperature_K);
  const double l2 = wavelength_um * wavelength_um;
  return kFirstRadiationConstant / (l2 * l2 * wavelength_um * std::expm1(x));
}

}  // namespace raycube::base
