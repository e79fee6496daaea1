// Reading a render table between its nodes, in double. Every function returns a spectrum over the table's whole
// wavelength axis. The rules keep energy and sign (S18 of the requirements; AIR 5):
//   transmission    -ln T linear in height; along view zenith -ln T cos(zenith) linear
//   path radiance   L0/(1 - T) linear in height, zenith and azimuth
//   thermal path    the same;   thermal sky  linear in height and in the airmass of the zenith angle
//   sky             where the table holds the column's phase function P and scattering depth: light scattered once, c P
//   times
//                   its geometry, is taken out (c from the nodes around the sun), the rest is divided by the geometry
//                   of an even P and linear; else linear
//   LIDAR profiles  exponential in height
//   two-way factor  linear;   irradiance over height: ln E linear;   light between ground and air (S, T_dif, t): linear
// An axis of one node states that the rows do not vary along it. Outside an axis of several nodes: Error(input).
// Heights in metres above the scene's z = 0; angles in degrees; azimuths relative to the sun, of any sign, are folded.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "atmos_tables/render_table.h"

namespace raycube::atmos {

const std::vector<double>& wavelengths(const RenderTable& table);
std::vector<double> solar_irradiance(const RenderTable& table);

/// Top of the air to the target. With k-terms: their weighted sum.
std::vector<double> sun_transmission(const RenderTable& table, double height_m);
/// Target to sensor, 0 <= zenith_deg < 90.
std::vector<double> view_transmission(const RenderTable& table, double height_m, double zenith_deg);
/// R2; Error(input) when the row is absent (unless the transmissions carry k-terms, which give it exactly).
std::vector<double> two_way_factor(const RenderTable& table, double height_m, double zenith_deg);
/// T(sun to target to sensor) = T_sun T_view R2, or the sum over k of products.
std::vector<double> two_way_transmission(const RenderTable& table, double height_m, double zenith_deg);

/// Solar path radiance from target to sensor over black ground.
std::vector<double> path_radiance(const RenderTable& table, double height_m, double zenith_deg,
                                  double relative_azimuth_deg);
/// Solar sky radiance, the disc excluded, towards (zenith 0..90, azimuth relative to the sun).
std::vector<double> sky_radiance(const RenderTable& table, double height_m, double zenith_deg,
                                 double relative_azimuth_deg);

/// Light the path from target to sensor emits (and scatters of what it emits).
std::vector<double> path_radiance_thermal(const RenderTable& table, double height_m, double zenith_deg);
/// Emitted by the sky towards the target, from zenith 0..90; the same at every azimuth.
std::vector<double> sky_radiance_thermal(const RenderTable& table, double height_m, double zenith_deg);
/// What reflected thermal sky meets on its way up is T_view times this; 1 where the table has no such row.
std::vector<double> two_way_factor_thermal(const RenderTable& table, double height_m, double zenith_deg);
/// Relative airmass of Kasten & Young (Appl. Opt. 28, 4735, 1989) at a zenith angle 0..90 deg: sec z to 1 % up to 75
/// deg, 38 at the horizon, strictly rising. The thermal sky is read against it.
double airmass(double zenith_deg);

/// On a horizontal plane.
std::vector<double> diffuse_irradiance(const RenderTable& table, double height_m);
/// On a horizontal plane: the row, or E0 cos(sun zenith) T_sun where it is absent; 0 with the sun at or below the
/// horizon.
std::vector<double> direct_irradiance(const RenderTable& table, double height_m);

/// Whether the table separates ground and air: spherical_albedo, diffuse_view_transmission, diffuse_return and
/// diffuse_irradiance. Its sky and path radiances are then over black ground.
bool has_ground_coupling(const RenderTable& table);
/// S of the air above a height, seen from below.
std::vector<double> spherical_albedo(const RenderTable& table, double height_m);
/// T_dif: radiance at the sensor beside the direct path, per unit of isotropic upward radiance of the ground all
/// around.
std::vector<double> diffuse_view_transmission(const RenderTable& table, double height_m, double zenith_deg);
/// t: radiance that comes back down from a zenith angle 0..90, per unit of isotropic upward radiance.
std::vector<double> diffuse_return(const RenderTable& table, double height_m, double zenith_deg);

/// A LIDAR table (compiler/lidar_profiles.h) at a height inside its profile, spectra over its wavelengths: extinction
/// and backscatter exponential in height (linear next to a 0), depolarisation linear.
struct LidarAir {
  std::vector<double> extinction_molecular_per_m, extinction_aerosol_per_m;
  std::vector<double> extinction_gas_per_m;  ///< 0 when the table has no such row
  std::vector<double> backscatter_molecular_per_m_sr, backscatter_aerosol_per_m_sr;
  std::vector<double> depolarization;  ///< perpendicular over parallel
};
LidarAir lidar_air(const RenderTable& table, double height_m);
/// Vertical extinction depth between two heights of the profile, one way: the exact integral of lidar_air's
/// extinctions.
std::vector<double> lidar_optical_depth(const RenderTable& table, double low_m, double high_m);

/// Rule for elevated targets when a solver gives upward radiance at levels: L0(z to H) = L_up(H) - T(z to H) L_up(z),
/// both over black ground in one direction from one run. A result below zero by rounding (1e-5 of L_up(H)) becomes 0.
double path_radiance_between(double up_at_sensor, double transmission, double up_at_target);

/// Piecewise linear in wavelength onto another grid, which must lie inside the first.
std::vector<double> resample_linear(const std::vector<double>& from_um, const std::vector<double>& values,
                                    const std::vector<double>& to_um);

/// Single-scatter shape that divides the sky: P mu0/(mu0 - mu)(exp(-tau/mu0) - exp(-tau/mu)), finite at mu = mu0 and mu
/// = 0. For suns below 2.9 degrees of elevation it is that of 2.9 degrees, and tau counts up to 3 mu0: neither
/// exponential falls below exp(-3) where the other does not, whatever the sun and the air.
double sky_shape(double phase, double depth, double cos_sun, double cos_view);

/// Sky nodes by which the light scattered once is told from the rest: the node nearest the sun first, then those around
/// it. Of a sun below 2.9 degrees of elevation: at 87 degrees of zenith, and beside. Pairs (zenith index, azimuth
/// index).
std::vector<std::pair<std::size_t, std::size_t>> nodes_around_sun(const std::vector<double>& sky_zenith_deg,
                                                                  const std::vector<double>& sky_azimuth_deg,
                                                                  double sun_zenith_deg);
/// A sky node: the phase function there, and its radiance over sky_shape with phase 1.
struct SkyNode {
  double phase, level;
};
/// c of level = c phase + rest, rest smooth: the rise from the surrounding nodes to the first. 0 where the phase
/// function has no peak there.
double once_scattered_level(const std::vector<SkyNode>& nodes);

/// Azimuth difference folded to 0..180.
double fold_azimuth(double degrees);

}  // namespace raycube::atmos
