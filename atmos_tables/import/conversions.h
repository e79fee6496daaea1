// The border: each foreign unit and angle convention of an imported file, converted once, by a named function.
#pragma once

#include <cmath>
#include <numbers>

#include "host/base/units.h"

namespace raycube::atmos::imported {

/// What a spectral axis counts in; densities of the same file are per that unit.
enum class AxisUnit { per_cm, um, nm };

constexpr double wavelength_um_from_axis(double value, AxisUnit unit) {
  return unit == AxisUnit::per_cm ? base::um_from_wavenumber_per_cm(value)
         : unit == AxisUnit::nm   ? base::um_from_nm(value)
                                  : value;
}

constexpr const char* axis_unit_name(AxisUnit unit) {
  return unit == AxisUnit::per_cm ? "cm-1" : unit == AxisUnit::nm ? "nm" : "um";
}

/// MODTRAN's W cm-2 [sr-1] per axis unit to W m-2 [sr-1] um-1. Per cm-1: x 1e8 / lambda^2 (9.0e-6 at 1000 cm-1 is 9.0).
constexpr double W_per_m2_um_from_W_per_cm2_axis(double density, AxisUnit unit, double wavelength_um) {
  return unit == AxisUnit::per_cm ? base::W_per_m2_sr_um_from_W_per_cm2_sr_per_cm(density, wavelength_um)
         : unit == AxisUnit::nm   ? density * 1e7
                                  : base::W_per_m2_sr_um_from_W_per_cm2_sr_um(density);
}

/// W m-2 [sr-1] (cm-1)-1 to W m-2 [sr-1] um-1 (uvspec's output_process per_cm-1).
constexpr double W_per_m2_um_from_W_per_m2_per_cm(double density, double wavelength_um) {
  return density * 1e4 / (wavelength_um * wavelength_um);
}
constexpr double W_per_m2_um_from_mW_per_m2_nm(double density) { return density; }
constexpr double W_per_m2_um_from_W_per_m2_nm(double density) { return density * 1e3; }
constexpr double W_per_m2_from_mW_per_m2(double irradiance) { return irradiance * 1e-3; }
/// Photons s-1 cm-2 [sr-1] nm-1 at a vacuum wavelength: h c / lambda each, h c = 1.98644586e-25 J m (CODATA 2018).
constexpr double W_per_m2_um_from_photons_per_s_cm2_nm(double density, double wavelength_um) {
  return density * 1e4 * 1e3 * 1.98644586e-25 / (wavelength_um * 1e-6);
}
constexpr double m_from_km(double length_km) { return length_km * 1e3; }

/// Any azimuth difference folded to 0..180 degrees.
inline double folded_azimuth_deg(double difference_deg) { return std::abs(std::remainder(difference_deg, 360.0)); }

/// Any azimuth turned to 0..360 degrees.
inline double azimuth_deg_0_to_360(double azimuth_deg) {
  const double rest = std::fmod(azimuth_deg, 360.0);
  return rest < 0 ? rest + 360.0 : rest;
}

/// MODTRAN gives the zenith of the line of sight at the observer (180 = straight down) and the earth-centre angle of
/// the path. In the plane of both points and the earth's centre the target sees the sensor at 180 - zenith + beta
/// (refraction left out).
inline double view_zenith_deg_from_modtran(double observer_zenith_deg, double earth_centre_angle_deg) {
  return 180.0 - observer_zenith_deg + earth_centre_angle_deg;
}

/// MODTRAN's PARM1 (IPARM = 2): azimuth of the sun minus that of the line of sight, seen from the observer. The line of
/// sight runs to the target, so the sensor lies 180 degrees from it.
inline double relative_azimuth_deg_from_modtran(double parm1_deg) { return folded_azimuth_deg(180.0 - parm1_deg); }
/// The same of a sight above the horizon: the sky point lies along it.
inline double sky_relative_azimuth_deg_from_modtran(double parm1_deg) { return folded_azimuth_deg(-parm1_deg); }

/// uvspec's umu > 0 is light going up, towards a sensor; umu < 0 light coming down from a sky point.
inline double zenith_deg_from_umu(double umu) { return base::deg_from_rad(std::acos(std::abs(umu))); }

/// uvspec's phi is the azimuth light travels in. Light coming down with phi = phi0 comes from the sun's side; light
/// going up with phi = phi0 goes to a sensor on the far side.
inline double relative_azimuth_deg_from_uvspec(double umu, double phi_deg, double phi0_deg) {
  return folded_azimuth_deg(phi_deg - phi0_deg + (umu > 0 ? 180.0 : 0.0));
}

}  // namespace raycube::atmos::imported
