// One phase function known at a few angles: smooth between them, integral over the sphere 4 pi, moments kept.
//
// ln P is a monotone cubic (Fritsch & Carlson 1980, SIAM J. Numer. Anal. 17, 238) of the angle, flat at 0 and 180
// degrees where P is even. Tables with a narrow forward peak hold too few angles to say how wide it is; their integral
// does. Where the cubic misses 4 pi by more than 2e-3, the first interval is ln P = ln P1 + (ln P0 - ln P1)(1 - (angle
// / angle1)^q) instead, and q (1 = the log-linear rule) is the one that makes the integral 4 pi: sideways and backward
// scattering keep their figures. A smaller miss is rounding, and one factor on everything.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::atmos {

class PhaseShape {
 public:
  /// angle_deg: 0 ... 180, ascending, at least 4; log_phase: ln P there, any factor. Throws Error(bug) when they do not
  /// match.
  PhaseShape(std::vector<double> angle_deg, std::vector<double> log_phase);

  double value(double cos_angle) const;
  /// P at 180 degrees.
  double backward() const { return backward_; }
  /// chi_k = 1/2 int P P_k dmu, k = 0..last; chi_0 = 1. The first 256 are kept from construction on.
  std::vector<double> moments(std::size_t last) const;
  double asymmetry() const { return kept_[1]; }
  /// q above; 0 where the cubic holds from 0 degrees on.
  double peak_exponent() const { return peak_exponent_; }

 private:
  struct Nodes {
    std::vector<double> cosine, weight, value;  ///< sum weight value = 1/2 int P dmu
  };
  double log_at(double angle_deg) const;
  /// Of the intervals first ... end - 1, dense enough for moments up to last.
  Nodes nodes(std::size_t last, std::size_t first, std::size_t end) const;
  std::vector<double> integrate(std::size_t last) const;

  std::vector<double> angle_deg_, log_phase_, slope_;
  double peak_exponent_ = 0, backward_ = 0;
  std::vector<double> kept_;
};

}  // namespace raycube::atmos
