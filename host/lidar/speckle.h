// Speckle: how many modes a receiver averages, and what they do to counts (LIDAR specification, section 9).
#pragma once

#include <cstdint>
#include <vector>

#include "host/lidar/lidar_plan.h"

namespace raycube::lidar {

/// Spatial modes M >= 1 of a spot on a rough target seen by a circular pupil (radius, obscuration radius): pupil area
/// over the integral of the pupil's autocorrelation times |coherence|^2 of the spot. Gaussian spot (1/e2 radius):
/// exp(-(pi w s / (lambda R))^2); uniform disc (edge): (2 J1(x)/x)^2, x = 2 pi a s / (lambda R). Goodman, Speckle
/// Phenomena (2007), 4.4. Relative error 1e-6.
double spatial_modes(double pupil_m, double obscuration_m, bool gaussian, double spot_m, double wavelength_m,
                     double range_m);

/// Autocorrelation of a circular pupil or annulus, clear area times K(s), m2.
double pupil_autocorrelation(double pupil_m, double obscuration_m, double shift_m);

/// Area over which a structured footprint's light is spread: (sum e)^2 / sum(e^2 / cell), m2; pi w^2 for a Gaussian, pi
/// a^2 for a disc. Every sub-ray stands for a cell of the target.
double effective_area_m2(const std::vector<double>& energy, const std::vector<double>& cell_m2);

/// Spectral-temporal modes of a pulse with a line's width: sqrt(1 + (dnu dt)^2), full widths at half maximum, Hz and s.
double temporal_modes(double line_width_hz, double pulse_s);
/// Width of a line in Hz: c fwhm / wavelength^2, vacuum um.
double line_width_hz(double wavelength_um, double fwhm_um);

/// All modes of a return at a range: spatial x polarisation x temporal. Above 1 each; spot: w or edge at the range.
double speckle_modes(const scene::Lidar& lidar, int line, double half_divergence_rad, double range_m);

/// Factors of mean 1 on the expected bins of a row: one Gamma(M)/M draw for each return, since its bins see the same
/// scatterers. A return lies between the row's minima (dips below half of the lower side); longer than about 3 pulse
/// lengths it is cut in pulse lengths of their own draws, which is what counts its depth modes. strongest_modes: M of
/// the block with the most light.
struct SpeckleRow {
  std::vector<double> factor;  ///< [bin]
  double strongest_modes = 0;
};
SpeckleRow speckle_row(const LidarPlan& plan, const Shot& shot, int pixel, int line,
                       const std::vector<double>& expected);

/// Probability of k counts of mean N with M modes; M = 0: Poisson.
double negative_binomial_probability(double k, double mean, double modes);

}  // namespace raycube::lidar
