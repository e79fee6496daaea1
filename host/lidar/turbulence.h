// Optical turbulence along a path: closed forms and path integrals (LIDAR specification, section 8). Kolmogorov
// spectrum, no inner or outer scale; k = 2 pi / wavelength. Lengths m, angles rad, Cn2 m^-2/3.
#pragma once

#include <functional>
#include <vector>

#include "scene_compiler/lidar_spec.h"

namespace raycube::lidar {

/// Refractive-index structure parameter at a height above the ground. Hufnagel-Valley: 0.00594 (v/27)^2 (1e-5 h)^10
/// exp(-h/1000) + 2.7e-16 exp(-h/1500) + A exp(-h/100); constant: everywhere the same; below the ground its value.
double cn2_at(const scene::LidarTurbulence& turbulence, double height_m);

/// A straight path from the transmitter: heights above the ground at its ends and, where the ground below is
/// not one plane, between them.
struct TurbulentPath {
  double length_m = 0, start_height_m = 0, end_height_m = 0;
  std::function<double(double z_m)> height_m =
      {};          ///< above the ground, z_m from the transmitter; empty: straight between the ends
  int pieces = 1;  ///< equal ones that follow height_m
};

/// Quadrature nodes of a path: distance from the transmitter and Cn2 times weight. Pieces follow the layers
/// of the profile; powers such as z^(5/3) and (L - z)^(5/6) integrate to 1e-8 over plane ground.
struct PathNodes {
  double length_m = 0;
  std::vector<double> z_m, cn2_dz;
};
PathNodes path_nodes(const scene::LidarTurbulence& turbulence, const TurbulentPath& path);

/// Fried's length of a plane wave, [0.423 k^2 int Cn2 dz]^(-3/5).
double fried_plane_m(const PathNodes& path, double wavelength_m);
/// Of a point at the path's end as the transmitter's (or a receiver's there) aperture sees it: weight (1 - z/L)^(5/3),
/// z from the transmitter. Image blur and tilt, and by reciprocity the spread of the outgoing spot: turbulence near the
/// aperture counts.
double fried_at_start_m(const PathNodes& path, double wavelength_m);
/// Of the transmitter as the target sees it: weight (z/L)^(5/3); turbulence near the target counts (scintillation there
/// alone).
double fried_at_end_m(const PathNodes& path, double wavelength_m);
/// Isoplanatic angle seen from the path's start, [2.914 k^2 int Cn2 z^(5/3) dz]^(-3/5).
double isoplanatic_angle_rad(const PathNodes& path, double wavelength_m);

/// Rytov variance of irradiance: plane wave 2.25 k^(7/6) int Cn2 (L - z)^(5/6) dz (1.2285 Cn2 k^(7/6) L^(11/6) if
/// constant), spherical wave with [z (L - z)/L]^(5/6) (0.4967).
double rytov_plane(const PathNodes& path, double wavelength_m);
double rytov_spherical(const PathNodes& path, double wavelength_m);

/// Long-term 1/e2 radius at the path's end: w^2 + 8 L^2 / (k rho0)^2, rho0 = fried_at_start / 2.10.
double long_term_radius_m(const PathNodes& path, double wavelength_m, double beam_radius_m);
/// Standard deviation per axis of the beam's centre at the path's end: sqrt(c int Cn2 (L - z)^2 w(z)^(-1/3) dz); c =
/// 2.284 (first order, Gaussian weight) or, Andrews & Phillips' 2.42 Cn2 L^3 w^(-1/3) for both axes, 3.63. w(z)^2 =
/// exit^2 + (divergence z)^2.
double wander_sigma_m(const PathNodes& path, double exit_radius_m, double half_divergence_rad, bool andrews);
/// Short-term radius: long^2 - 4 sigma^2, not below the beam without turbulence (clamped tells).
struct ShortTerm {
  double radius_m = 0;
  bool clamped = false;
};
ShortTerm short_term_radius(double long_term_m, double wander_m, double beam_radius_m);

/// Modulation of an image at a frequency in cycles / rad: long exposure exp(-3.44 (lambda nu / r0)^(5/3)); short
/// exposure: the exponent times
/// 1 - (lambda nu / D)^(1/3), D the aperture's diameter.
double long_exposure_mtf(double cycles_per_rad, double wavelength_m, double fried_m);
double short_exposure_mtf(double cycles_per_rad, double wavelength_m, double fried_m, double diameter_m);
/// Angle of arrival per axis, rad: centroid of the image (G-tilt) 0.170, tilt of the wave's best plane (Z-tilt) 0.182
/// times (lambda / D)^2 (D / r0)^(5/3), square root.
double image_tilt_rad(double wavelength_m, double fried_m, double diameter_m);
double wave_tilt_rad(double wavelength_m, double fried_m, double diameter_m);

/// Temporal broadening: 8 a1 with a1 = 0.391 int Cn2 dz L0^(5/3) / c^2, s^2, added to the squared half width at 1/e2 of
/// power. Below 1e-11 s in any air: invisible to bins of 10 ps.
double broadening_s2(const PathNodes& path, double outer_scale_m);
/// Full width at half maximum of a Gaussian pulse so broadened.
double broadened_fwhm_s(double fwhm_s, double broadening_s2);

}  // namespace raycube::lidar
