// Divided differences of exp(-x). Every integral of an attenuated source along an attenuated line of sight is
// one of them, and their limits (beam cosine = eigenvalue, = view cosine, = node) are ordinary points: the
// classical closed forms are 0/0 there.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace raycube::atmos::solver {

/// (1 - exp(-x)) / x; 1 at x = 0. Any x > -700.
double exp_mean(double x);

/// (exp(-x) - exp(-y)) / (y - x), symmetric, positive; exp(-x) where x = y. x, y >= 0. Relative error below
/// 1e-15.
double exp_difference(double x, double y);

/// Second divided difference (f(x,y) - f(x,z)) / (z - y) of f = exp_difference; symmetric, positive;
/// exp(-x)/2 where all agree. x, y, z >= 0. Relative error below 1e-14.
double exp_difference(double x, double y, double z);

// The same where the exponentials themselves are known, inline for the innermost loops. Closer than kNear the
// difference of two exponentials would lose digits (it loses three bits there) and a series of ten terms is
// exact to 1e-16.
inline constexpr double kNear = 0.125;
/// (-1)^n / (n + 2)!, n = 1 ... 9
inline constexpr std::array<double, 9> kInverseFactorials = {
    -1.0 / 6, 1.0 / 24, -1.0 / 120, 1.0 / 720, -1.0 / 5040, 1.0 / 40320, -1.0 / 362880, 1.0 / 3628800, -1.0 / 39916800};

/// exp_difference(x, y) from exp_x = exp(-x), exp_y = exp(-y).
inline double exp_pair(double x, double y, double exp_x, double exp_y) {
  const double gap = y - x;
  if (std::abs(gap) > kNear) return (exp_x - exp_y) / gap;
  const double p = std::abs(gap);
  double sum = 1 - p / 11;  // (1 - exp(-p)) / p = 1 - p/2 (1 - p/3 (1 - ...
  sum = 1 - p * (1.0 / 10) * sum;
  sum = 1 - p * (1.0 / 9) * sum;
  sum = 1 - p * (1.0 / 8) * sum;
  sum = 1 - p * (1.0 / 7) * sum;
  sum = 1 - p * (1.0 / 6) * sum;
  sum = 1 - p * (1.0 / 5) * sum;
  sum = 1 - p * (1.0 / 4) * sum;
  sum = 1 - p * (1.0 / 3) * sum;
  sum = 1 - p * 0.5 * sum;
  return std::max(exp_x, exp_y) * sum;
}

/// exp_difference(x, y, z) from the three exponentials and the three pairs' differences.
inline double exp_triple(const std::array<double, 3>& at, const std::array<double, 3>& exp_at, double pair_xy,
                         double pair_xz, double pair_yz) {
  const double xy = std::abs(at[1] - at[0]), xz = std::abs(at[2] - at[0]), yz = std::abs(at[2] - at[1]);
  const double widest = std::max({xy, xz, yz});
  if (widest > kNear) {
    if (xz == widest) return (pair_xy - pair_yz) / (at[2] - at[0]);
    if (xy == widest) return (pair_xz - pair_yz) / (at[1] - at[0]);
    return (pair_xy - pair_xz) / (at[2] - at[1]);
  }
  // Sum over n of (-1)^n h_n(p, q) / (n + 2)!, h_n the complete homogeneous polynomial; p <= q: distances
  // from the lowest of the three.
  const double lowest = std::min({at[0], at[1], at[2]});
  const double q = widest, p = std::max(0.0, at[0] + at[1] + at[2] - 3 * lowest - q);
  double sum = 0.5, homogeneous = 1, power = 1;
  for (double factor : kInverseFactorials) {
    power *= p;
    homogeneous = homogeneous * q + power;
    sum += factor * homogeneous;
  }
  return std::max({exp_at[0], exp_at[1], exp_at[2]}) * sum;
}

}  // namespace raycube::atmos::solver
