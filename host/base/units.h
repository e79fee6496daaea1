// Conversions between the units users write and the ones we store, each a named function. Stored: wavelength um in
// vacuum, radiance W m-2 sr-1 um-1, angles rad inside formulas, degrees in files.
#pragma once

#include <numbers>

namespace raycube::base {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kLightSpeed_m_s = 299792458.0;
/// Of a Gaussian: full width at half maximum over standard deviation, 2 sqrt(2 ln 2), and its inverse.
inline constexpr double kFwhmOfSigma = 2.3548200450309493, kSigmaOfFwhm = 0.42466090014400953;

constexpr double um_from_nm(double wavelength_nm) { return wavelength_nm * 1e-3; }
constexpr double nm_from_um(double wavelength_um) { return wavelength_um * 1e3; }
constexpr double um_from_wavenumber_per_cm(double wavenumber_per_cm) { return 1e4 / wavenumber_per_cm; }

/// A width in wavenumber (cm-1) at a wavelength, as a width in wavelength: |d lambda| = lambda^2 / 1e4 |d nu| (first
/// order).
constexpr double width_um_from_per_cm(double width_per_cm, double wavelength_um) {
  return width_per_cm * wavelength_um * wavelength_um * 1e-4;
}

/// 1 uW cm-2 sr-1 nm-1 (AVIRIS) = 10 W m-2 sr-1 um-1.
constexpr double W_per_m2_sr_um_from_uW_per_cm2_sr_nm(double radiance) { return radiance * 10.0; }
constexpr double uW_per_cm2_sr_nm_from_W_per_m2_sr_um(double radiance) { return radiance * 0.1; }
/// 1 W cm-2 sr-1 um-1 (DIRSIG) = 1e4 W m-2 sr-1 um-1.
constexpr double W_per_m2_sr_um_from_W_per_cm2_sr_um(double radiance) { return radiance * 1e4; }
constexpr double W_per_cm2_sr_um_from_W_per_m2_sr_um(double radiance) { return radiance * 1e-4; }
/// Per wavenumber to per wavelength: L_lambda = L_nu 1e4 / lambda^2 with lambda in um; W cm-2 sr-1 (cm-1)-1 (MODTRAN)
/// in.
constexpr double W_per_m2_sr_um_from_W_per_cm2_sr_per_cm(double radiance, double wavelength_um) {
  return radiance * 1e4 * 1e4 / (wavelength_um * wavelength_um);
}
constexpr double W_per_cm2_sr_per_cm_from_W_per_m2_sr_um(double radiance, double wavelength_um) {
  return radiance * wavelength_um * wavelength_um * 1e-8;
}

constexpr double rad_from_deg(double angle_deg) { return angle_deg * (std::numbers::pi / 180.0); }
constexpr double deg_from_rad(double angle_rad) { return angle_rad * (180.0 / std::numbers::pi); }

/// The same with two roundings, as the bytes of tables and products have always had it: another last bit. For code that
/// began with it; new code takes those above.
constexpr double rad_by_division(double angle_deg) { return angle_deg * std::numbers::pi / 180; }
constexpr double deg_by_division(double angle_rad) { return angle_rad * 180 / std::numbers::pi; }

}  // namespace raycube::base
