// How much of a point's light enters the receiver: geometric form factor, exact per point (LIDAR specification, section
// 4.3).
#pragma once

namespace raycube::lidar {

/// Area common to two circles of radii a and b whose centres are d apart. All >= 0; clamped, never NaN.
double circle_overlap(double a, double b, double d);

/// A circular field stop behind a circular pupil.
struct Stop {
  double pupil_m = 0.05, obscuration_m = 0;  ///< radii
  double half_fov_rad = 0;
  double focus_m = 0;  ///< 0: infinity
};
/// Share of the clear pupil that a point at `range_m` along the axis, `offset_m` off it, passes through to the
/// detector; 0 .. 1.
double vignetting(const Stop& stop, double range_m, double offset_m);

/// Overlap of a beam with the field at a range: mean of vignetting over the beam. Gaussian of 1/e2 radius or uniform
/// disc; the beam's centre `offset_m` off the receiver's axis. Relative error 1e-7.
double beam_overlap(const Stop& stop, bool gaussian, double beam_radius_m, double range_m, double offset_m);

/// Hard circle of radius pupil + half_fov range against a Gaussian beam: 1 - Q1(2d/w, 2a/w). A debugging aid.
double gaussian_circle_overlap(double beam_radius_m, double circle_m, double offset_m);
/// The same for a uniform beam.
double uniform_circle_overlap(double beam_radius_m, double circle_m, double offset_m);

}  // namespace raycube::lidar
