// The render table as whole spectra at one geometry, for a range of its wavelength axis: a view on
// atmos_tables/interpolate.h that knows airless simulations, and samples the sky on a whole grid of directions at once.
// Angles in radians; azimuth relative to the sun; heights m above scene z = 0.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "atmos_tables/render_table.h"

namespace raycube::plan {

using Spectrum = std::vector<double>;

/// Whose light a sky is: scattered sunlight, or what the air emits (the same at every azimuth).
enum class Sky { solar, thermal };

class TableSpectra {
 public:
  /// Covers table wavelengths first .. first + count - 1. `no_air`: only solar_irradiance is read;
  /// transmissions are 1, there is no sky and no path radiance. Throws Error(input) when a row is missing
  /// that a render with air needs: the solar rows, unless the table holds both thermal ones; then what it
  /// lacks of the sun's is dark. A table that ends below base::kHeatFrom_um may hold path_radiance_thermal
  /// alone: its thermal sky is black. `sun_up` false: no direct light. `ground`: mean reflectance of the
  /// ground on the covered wavelengths; given, light goes between ground and air (S4.9), the sky carries what
  /// the air sends back down, and the table must have the rows for it.
  TableSpectra(const atmos::RenderTable& table, bool no_air, bool sun_up, std::size_t first, std::size_t count,
               Spectrum ground = {});

  std::size_t size() const { return count_; }
  bool thermal() const { return thermal_; }  ///< light that the air emits is read: the table's thermal rows
  void leave_out_emission() { thermal_ = has_thermal_sky_ = false; }  ///< from now on the air emits nothing
  bool has_sky(Sky sky = Sky::solar) const {
    return sky == Sky::solar ? has_sky_ : has_thermal_sky_;
  }                                                                          ///< some sky radiance above zero
  const std::vector<double>& sky_zenith_rad() const { return sky_zenith_; }  ///< the table's own nodes
  std::vector<double> sky_azimuth_rad(Sky sky = Sky::solar) const;
  double last_view_zenith_rad() const { return last_view_zenith_; }  ///< largest slant of the table; pi/2 without air

  Spectrum sun(double height_m) const;  ///< E0 T_sun on a plane facing the sun, W m-2 um-1
  Spectrum view_transmission(double height_m, double zenith_rad) const;
  Spectrum two_way_transmission(double height_m, double zenith_rad) const;    ///< T_sun T_view R2
  Spectrum two_way_factor_thermal(double height_m, double zenith_rad) const;  ///< of reflected thermal sky
  Spectrum two_way_factor(double height_m, double zenith_rad) const;  ///< R2 = T(sun-target-sensor) / (T_sun T_view)
  Spectrum path_radiance(double height_m, double zenith_rad,
                         double azimuth_rad) const;  ///< solar and thermal, W m-2 sr-1 um-1
  Spectrum emitted_path(double height_m,
                        double zenith_rad) const;  ///< its thermal part; the table must hold the row
  Spectrum solar_irradiance() const;               ///< E0; zero when the sun is down
  /// The table's own row, with what ground and air add to it; empty when it has none.
  Spectrum diffuse_irradiance(double height_m) const;

  /// The table holds what light between ground and air takes: its diffuse_irradiance is the flux of its very sky, over
  /// black ground.
  bool knows_flux_of_sky() const;
  bool couples_ground() const { return !ground_.empty(); }
  /// Isotropic upward radiance of ground of unit reflectance: E_g0 / (pi (1 - ground S)), E_g0 sun and sky over black
  /// ground.
  Spectrum ground_radiance(double height_m) const;
  /// What of that the air scatters to the sensor: T_dif, times the two-way factor as for all light that the ground
  /// reflects.
  Spectrum diffuse_view_transmission(double height_m, double zenith_rad) const;

  /// Sky radiance at every (zenith, azimuth) of a product grid: out[(wavelength * zeniths + z) * azimuths + a], which
  /// is filled whole. Same rule as atmos::sky_radiance (divided by the single-scatter shape between nodes), evaluated
  /// once per node instead of per call.
  void sky_grid(double height_m, const std::vector<double>& zenith_rad, const std::vector<double>& azimuth_rad, Sky sky,
                std::span<double> out) const;
  /// Of `count` wavelengths from this one on, counted as size() does.
  void sky_grid(double height_m, const std::vector<double>& zenith_rad, const std::vector<double>& azimuth_rad, Sky sky,
                std::size_t from, std::size_t count, std::span<double> out) const;

 private:
  Spectrum slice(const Spectrum& whole) const;
  double clamp_height(double height_m) const;

  const atmos::RenderTable& table_;
  bool no_air_, sun_up_;
  bool has_sky_ = false, has_thermal_sky_ = false, thermal_ = false, path_scatters_ = false;
  std::size_t first_, count_;
  std::vector<double> sky_zenith_, sky_azimuth_;
  Spectrum ground_;
  double last_view_zenith_;
};

}  // namespace raycube::plan
