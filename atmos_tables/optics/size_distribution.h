// How many spheres of each radius a cloud of them holds, per sphere: integral 1.
#pragma once

#include <functional>
#include <vector>

namespace raycube::atmos {

/// One lognormal mode: dN/dln r = share / (sqrt(2 pi) ln s) exp(-(ln r - ln median)^2 / (2 ln^2 s)).
struct LogNormalMode {
  double share = 1;             ///< of the number of spheres; shares are normalised to sum 1
  double median_radius_um = 0;  ///< of the number distribution
  double geometric_sigma = 0;   ///< s, 1.01..10 (10^sigma where a source gives the decadic logarithm)
};

class SizeDistribution {
 public:
  /// One or more modes. Throws Error(input) that lists every bad figure.
  static SizeDistribution lognormal(const std::vector<LogNormalMode>& modes);
  /// n(r) ~ r^alpha exp(-b r^gamma), r in um (Deirmendjian 1969, "Electromagnetic Scattering on Spherical
  /// Polydispersions"). Haze L: alpha 2, b 15.1186, gamma 0.5; cloud C.1: 6, 1.5, 1. All parameters > 0.
  static SizeDistribution modified_gamma(double alpha, double b, double gamma);

  /// dN/dln r at ln(r / um).
  double per_log_radius(double log_radius) const { return density_(log_radius); }
  /// Logarithms of radii between which all but a negligible part of any moment up to r^6 lies.
  double first_log_radius() const { return first_; }
  double last_log_radius() const { return last_; }

 private:
  std::function<double(double)> density_;
  double first_ = 0, last_ = 0;
};

}  // namespace raycube::atmos
