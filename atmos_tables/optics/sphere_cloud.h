// Optics of many spheres of one substance and many sizes: Mie's series integrated over ln r. Each sphere scatters for
// itself.
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

#include "atmos_tables/optics/gauss_legendre.h"
#include "atmos_tables/optics/size_distribution.h"

namespace raycube::atmos {

struct SphereCloudRequest {
  double wavelength_um = 0;       ///< in the medium around the spheres
  std::complex<double> index;     ///< n + i k, k >= 0 absorbs
  double tolerance = 1e-4;        ///< 1e-8..0.1, see SphereCloudOptics::change
  std::size_t last_moment = 0;    ///< chi_0..chi_last come back
  std::vector<double> angle_deg;  ///< scattering angles 0..180 at which the phase function is wanted
};

/// Means per sphere. Extinction coefficient in km-1 = spheres per cm3 times extinction_um2 times 1e-3.
struct SphereCloudOptics {
  double extinction_um2 = 0, scattering_um2 = 0, single_scattering_albedo = 0, asymmetry = 0;
  /// Phase function, integral over the sphere 4 pi: at the rule's nodes, and at the angles asked for.
  GaussRule rule;
  std::vector<double> phase, phase_at_angle;
  /// chi_k = 1/2 int P P_k dmu; P = sum (2k + 1) chi_k P_k.
  std::vector<double> moments;
  /// What the last halving of the step in ln r changed, the largest of: extinction and scattering (relative),
  /// asymmetry, and 1/2 int |change of P| dmu, which bounds the change of every moment. Never above the tolerance.
  /// Spheres left out at both ends of the distribution add less than a tenth of the tolerance.
  double change = 0;
  std::size_t spheres = 0;  ///< sizes at which the series was summed
};

/// Trapezoidal rule in ln r, its step halved until the results settle. Throws Error(input) when a figure is out of
/// range, when spheres of size parameter above 5000 matter, or when 2^15 sizes do not reach the tolerance (resonances
/// of clear spheres).
SphereCloudOptics integrate_spheres(const SizeDistribution& sizes, const SphereCloudRequest& request);

}  // namespace raycube::atmos
