// What turbulence does to a shot: a wider beam, a wandering axis, a tilted view, a flickering return.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "host/lidar/lidar_plan.h"

namespace raycube::lidar {

/// Scintillation is drawn as gamma-gamma from this Rytov variance of a plane wave on, below it as log-normal.
inline constexpr double kGammaGammaFrom = 0.3;

/// What a shot meets on its way.
struct ShotSurroundings {
  /// Plane ground, nothing on the way to it.
  ShotSurroundings(double flat_ground_z_m) : flat_z_m(flat_ground_z_m) {}
  ShotSurroundings(std::function<double(double x_m, double y_m)> ground, double surface_m)
      : ground_z_m(std::move(ground)), surface_range_m(surface_m) {}

  double flat_z_m = 0;                                       ///< where ground_z_m is empty
  std::function<double(double x_m, double y_m)> ground_z_m;  ///< scene z of the ground below a place
  double surface_range_m = 0;  ///< of the first surface on the exit's axis; 0: it meets none
  double ground_at(double x_m, double y_m) const { return ground_z_m ? ground_z_m(x_m, y_m) : flat_z_m; }
};

/// How the irradiance of one line flickers.
struct LineScintillation {
  double rytov_plane = 0, rytov_spherical = 0;  ///< variances
  double index_down = 0, index_up = 0;          ///< one-way indices, averaged over footprint and aperture
  bool gamma_gamma = false;                     ///< else log-normal; by rytov_plane
};

/// Everything that was computed and drawn for a shot; angles rad, lengths m at the path's end.
struct TurbulenceTruth {
  double path_m = 0, start_height_m = 0, end_height_m = 0;  ///< heights above the ground
  double rytov_plane = 0, rytov_spherical = 0;              ///< variances
  double fried_m = 0;          ///< of the image and the outgoing spot: a point at the path's end seen from its start
  double fried_plane_m = 0;    ///< of a plane wave over the same path
  double isoplanatic_rad = 0;  ///< seen from the path's start
  double beam_radius_m = 0, long_term_m = 0, short_term_m = 0, wander_sigma_m = 0;
  bool spread_clamped = false;  ///< wander took more than all spread: the short-term spot stays the beam's
  std::array<double, 2> wander_rad{}, tilt_rad{};  ///< drawn, along u and v
  double tilt_sigma_rad = 0;                       ///< per axis, motion of the image's centroid
  double blur_fwhm_rad = 0;                        ///< long exposure, 0.98 lambda / r0
  double index_down = 0,
         index_up = 0;                   ///< one-way scintillation, averaged over footprint (down) and aperture (up)
  double index_total = 0;                ///< two-way, of what is received
  bool gamma_gamma = false;              ///< else log-normal
  std::vector<LineScintillation> lines;  ///< each at its own wavelength; everything else is the first line's
  double gain = 1;                       ///< of the first line
  double broadening_s2 = 0;              ///< temporal, see turbulence.h
  double correlation_s =
      0;  ///< max(short-term spot, fried) / wind, 0 without wind: lines of a shot closer than this share a draws
  std::vector<std::string> warnings;  ///< where the models are stretched; same text for the same cause
};

/// Widens half_divergence_rad by the short-term spread (long-term where wander is off), moves exit_axis and
/// exit_u by the wander, pupil_axis and pupil_u by the tilt (G-tilt, one draw for the whole receiver),
/// multiplies gain by the scintillation of the way down, averaged over the footprint, and of the way up,
/// averaged over the aperture: index (1 + down)(1 + up) - 1. Log-normal where the plane-wave Rytov variance
/// is below kGammaGammaFrom, gamma-gamma above. The path runs from the exit along the axis to the first
/// surface; where it meets none to the height of the ground below the exit; to the gate's end when that is
/// nearer or the axis does not point down. Heights of the profile count from the ground below each place of
/// the path, whatever the beam hits. Wavelength: the first line's, but scintillation has each line's own.
/// Several lines: gain stays, line_gain has one each: from one draw where they are no further apart
/// (separation_s) than correlation_s, else from a draw each; wander and tilt are common to them. Draws are
/// functions of (plan.seed, pulse, line). Does nothing without turbulence.
TurbulenceTruth apply_turbulence(const LidarPlan& plan, const ShotSurroundings& around, Shot& shot);

/// Multiplies a result's rows, and what its ledgers say reached the pupil, by shot.line_gain.
void apply_line_gain(const LidarPlan& plan, ShotResult& result);

/// Lengthens a plan's Gaussian pulse in quadrature (`broadening` on, not an impulse) where that changes its width by
/// more than 1e-6 of itself; tells whether it did. Other shapes stay.
bool broaden_pulse(LidarPlan& plan, double broadening_s2);

/// The same statistics without a draw (wander_rad, tilt_rad 0; gain 1).
TurbulenceTruth turbulence_statistics(const LidarPlan& plan, const ShotSurroundings& around, const Shot& shot);

}  // namespace raycube::lidar
