// The clear-sky spectral model of Bird & Riordan (1986), J. Climate Appl. Meteorol. 25, 87-97 ("SPCTRL2"), with the
// constants of the program NREL distributes: its transmittances, its diffuse irradiance, and its whole for checking.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::atmos {

/// One wavelength of the model's table.
struct BirdRiordanLine {
  double wavelength_um;
  double solar_irradiance;  ///< W m-2 um-1 at 1 AU
  double water;             ///< per cm of precipitable water
  double ozone;             ///< per atm-cm
  double mixed;             ///< uniformly mixed gases, per pressure-corrected airmass
};

/// The 122 lines, 0.3 to 4 um, ascending.
const std::vector<BirdRiordanLine>& bird_riordan_table();
/// Linear in wavelength between the lines. The wavelength must lie within 0.3..4 um.
BirdRiordanLine bird_riordan_at(double wavelength_um);

/// Optical depths of a path. The band models of water and mixed gases are not linear in the amount: add amounts, not
/// depths. water_cm: precipitable water along the path (g cm-2); eq. 2-8.
double water_depth(double coefficient, double water_cm);
/// mixed_airmass: path amount in units of one vertical air column of 1013 hPa; eq. 2-11.
double mixed_gas_depth(double coefficient, double mixed_airmass);

/// Path transmittances from the top of the air to a level, all along the slant path of the sun.
struct SlantTransmission {
  double rayleigh = 1;
  double aerosol_scattering = 1;  ///< exp(-omega tau M)
  double aerosol_absorption = 1;  ///< exp(-(1 - omega) tau M)
  double gas = 1;                 ///< ozone, water and mixed gases together
};

/// Forward fraction of aerosol scattering for the sun's cosine (eq. 3-11 .. 3-15): Fs.
double forward_fraction(double asymmetry, double cos_sun_zenith);

/// Diffuse irradiance on a horizontal plane over black ground, W m-2 um-1: (Ir + Ia) Cs, eq. 3-5, 3-6 and 3-17.
double diffuse_irradiance_black_ground(double wavelength_um, double solar_irradiance, double cos_sun_zenith,
                                       double asymmetry, const SlantTransmission& transmission);
/// Sky reflectance seen from the ground; transmissions at airmass 1.8 (eq. 3-9).
double sky_reflectance(double asymmetry, const SlantTransmission& at_airmass_1_8);
/// The short-wave correction Cs of eq. 3-17.
double short_wave_correction(double wavelength_um);

/// Inputs of the model as its authors wrote it.
struct BirdRiordanCase {
  double sun_zenith_deg = 0;  ///< apparent
  double airmass = 1;
  double pressure_Pa = 101300;
  double ozone_atm_cm = 0.3;
  double water_cm = 1.5;
  double aod_500 = 0.1;
  double angstrom = 1.14;
  double ground_albedo = 0.2;
  double asymmetry = 0.65;
  double ssa_400 = 0.945;
  int day_of_year = 75;
};
struct BirdRiordanLight {
  double extraterrestrial, direct_normal, diffuse_horizontal;  ///< W m-2 um-1
};
/// The original model at every line of its table.
std::vector<BirdRiordanLight> bird_riordan_model(const BirdRiordanCase& input);

/// Aerosol single-scattering albedo: omega(0.4 um) exp(-0.095 ln^2(l / 0.4)) (eq. 3-16).
double aerosol_albedo(double ssa_400, double wavelength_um);

/// Spencer (1971): (mean distance / distance)^2. day 1..366; 0 gives 1.
double earth_sun_factor(int day_of_year);

}  // namespace raycube::atmos
