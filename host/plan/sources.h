// The plan's source spectra at one geometry, on the table's wavelengths.
#pragma once

#include <numbers>

#include "host/plan/plan.h"
#include "host/plan/table_spectra.h"

namespace raycube::plan {

/// Ranges of the continuous quantities, each reached by a fraction t in 0..1.
struct Domain {
  double z_lo = 0, z_hi = 0;               ///< target height, m
  double sun_zenith = 0, sun_azimuth = 0;  ///< rad
  ViewBounds view;
  Spectrum lamplight;  ///< W m-2 um-1, typical_lamplight on the table's wavelengths that bands reach; empty: no lamps
  double z(double t) const { return z_lo + t * (z_hi - z_lo); }
  double sec(double t) const { return view.sec_min + t * (view.sec_max - view.sec_min); }
  double x(double t) const { return view.x_min + t * (view.x_max - view.x_min); }
  double y(double t) const { return view.y_min + t * (view.y_max - view.y_min); }
  double horizontal_max() const;  ///< sine of the largest view zenith
};

double zenith_of_sec(double sec);
Spectrum product(const Spectrum& a, const Spectrum& b, double factor = 1);

/// Reflected sun: E0 T_sun T_view R2 / pi, per unit of reflectance and of cos(incidence) times visibility.
Spectrum sun_source(const TableSpectra& air, double z, double sec);
/// What a reflected sky component meets on its way up: T_view R2 / pi, with the factor of its kind. Zero without such a
/// sky.
Spectrum sky_path(const TableSpectra& air, double z, double sec, Sky sky = Sky::solar);
/// Reflected lamplight of the domain, per unit of reflectance: E T_view / pi. Zero without lamps.
Spectrum lamp_source(const TableSpectra& air, const Domain& domain, double z, double sec);
/// Light of ground of unit reflectance all around that the air scatters into the path: T_dif R2 E_g0 / (pi (1 - rho
/// S)).
Spectrum environment_source(const TableSpectra& air, double z, double sec);
/// Path radiance towards a sensor in the horizontal direction (x, y); slants beyond the table's last view zenith, which
/// only nodes outside the view reach, take that zenith.
Spectrum path_source(const TableSpectra& air, const Domain& domain, double z, double x, double y);

}  // namespace raycube::plan
