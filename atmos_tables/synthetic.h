// Render tables whose every value is stated by the caller: real tables for tests, laboratories and closed forms.
#pragma once

#include <functional>
#include <vector>

#include "atmos_tables/render_table.h"

namespace raycube::atmos {

/// Spectra that do not vary with height, view or direction, each as a function of wavelength in um.
struct UniformAir {
  using Spectrum = std::function<double(double wavelength_um)>;
  Spectrum solar_irradiance = [](double) { return 1000.0; };  ///< W m-2 um-1 at the top of the air
  Spectrum sun_transmission = [](double) { return 1.0; };
  Spectrum view_transmission = [](double) { return 1.0; };
  Spectrum two_way_factor = [](double) { return 1.0; };
  Spectrum sky_radiance = [](double) { return 0.0; };   ///< W m-2 sr-1 um-1, the same in all directions
  Spectrum path_radiance = [](double) { return 0.0; };  ///< W m-2 sr-1 um-1
  /// Both given: the table gets thermal rows. W m-2 sr-1 um-1, the sky the same in all directions.
  Spectrum thermal_sky_radiance, thermal_path_radiance;
  Spectrum two_way_factor_thermal;  ///< absent from the table when not given
  /// Light between ground and air: S, T_dif and t. Empty: the table has no such row.
  Spectrum spherical_albedo, diffuse_view_transmission, diffuse_return;
  double sun_zenith_deg = 0, sun_azimuth_deg = 0;
  double sensor_height_m = 1000;
};

/// One-node axes: nothing varies along them. Wavelengths ascending, um.
RenderTable uniform_table(const UniformAir& air, const std::vector<double>& wavelength_um);

/// Air of one temperature and a vertical optical depth (1) that falls exponentially with height (scale height 2 km),
/// absorbing only: T = exp(-depth m), path B (1 - T_path), sky B (1 - T_sky), m = 1 / cos for the path and the airmass
/// for the sky. Targets from 0 to the sensor, views to 80 deg; black sky above. Thermal rows only: no sun.
RenderTable isothermal_table(double temperature_K, const UniformAir::Spectrum& depth, double sensor_height_m,
                             const std::vector<double>& wavelength_um);

/// Sun of irradiance E0 and a sky of uniform radiance through clear space: sky irradiance is pi times the radiance.
RenderTable uniform_sky_table(double solar_irradiance, double sky_radiance, const std::vector<double>& wavelength_um,
                              double sun_zenith_deg = 0, double sun_azimuth_deg = 0);

/// Absorption line of Gaussian optical depth: T = exp(-depth exp(-4 ln2 (l - center)^2 / fwhm^2)); lengths um.
double gaussian_line(double wavelength_um, double center_um, double fwhm_um, double depth);

/// first, first + step, ... last (the last step may be shorter). step > 0.
std::vector<double> wavelength_grid(double first_um, double last_um, double step_um);
/// A coarse grid with a fine stretch of the given step within half_width of center: for lines of 0.01 nm.
std::vector<double> wavelength_grid_with_line(double first_um, double last_um, double step_um, double center_um,
                                              double half_width_um, double fine_step_um);

}  // namespace raycube::atmos
