// What the solver is asked: a plane-parallel column of homogeneous layers, its light sources, the ground, and
// the accuracy.
#pragma once

#include <functional>
#include <vector>

namespace raycube::atmos::solver {

/// One homogeneous layer.
struct Layer {
  double optical_depth = 0;      ///< extinction, vertical; >= 0, 0 allowed
  double scattering_albedo = 0;  ///< single-scattering albedo, [0, 1]; 1 is conservative
  /// Legendre moments chi_k of the phase function, chi_0 = 1: P(Theta) = sum (2k+1) chi_k P_k(cos Theta),
  /// integral 4 pi. Henyey-Greenstein: g^k. Rayleigh: 1, 0, 0.1 (1-rho)/(1+rho/2). Empty = isotropic. Give
  /// more than `streams` where they exist.
  std::vector<double> phase_moments;
};

/// Parallel light on the top.
struct Beam {
  double flux = 0;         ///< irradiance normal to the beam (W m-2 um-1, or any unit: the answer has the same); >= 0
  double cosine = 1;       ///< cosine of the sun's zenith angle, (0, 1]
  double azimuth_deg = 0;  ///< azimuth into which the beam travels
};

/// The column, layers from the top down. Levels are the boundaries: level 0 the top, level layers.size() the
/// ground.
struct Column {
  std::vector<Layer> layers;  ///< may be empty
  Beam beam;
  std::vector<double> planck;  ///< Planck radiance at each level, linear in optical depth between; empty = no emission
  double top_radiance = 0;     ///< isotropic radiance that enters at the top
  /// Height of each level, strictly falling (m): the beam then takes the straight slant path through
  /// spherical shells (pseudo-spherical, atmosphere specification S4.7), with `beam.cosine` as seen at every
  /// level. Empty = plane-parallel beam.
  std::vector<double> level_height_m;
  double planet_radius_m = 6371e3;  ///< radius at height 0
  /// Phase functions of all layers at a cosine of the scattering angle, for light scattered once: where their moments
  /// converge slowly (a cusp forward, a kink backward: tabulated Mie functions). Empty = the series of all moments
  /// given.
  std::function<std::vector<double>(double cos_angle)> phase_values;
};

/// Lambertian ground.
struct Ground {
  double albedo = 0;  ///< [0, 1]
  double planck = 0;  ///< Planck radiance at the ground's temperature; it emits (1 - albedo) of it
};

/// Accuracy.
struct Options {
  int streams = 16;                  ///< both hemispheres together; even, 2 ... 256
  bool delta_m = true;               ///< truncate the forward peak (Wiscombe 1977, J. Atmos. Sci. 34, 1408)
  bool intensity_correction = true;  ///< Nakajima & Tanaka (1988, JQSRT 40, 51) TMS and IMS
  /// The azimuth series ends when two successive terms are below this part of the first one.
  double fourier_tolerance = 1e-8;
};

/// Throws base::Error(Fault::input) that lists every rule the column or the options break. NaN breaks all of
/// them.
void check_column(const Column& column, const Options& options);

/// Throws as above for a ground outside its range.
void check_ground(const Ground& ground);

}  // namespace raycube::atmos::solver
