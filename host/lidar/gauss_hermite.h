// Gauss-Hermite rules: averages over a normal distribution, as over the width of a laser line.
#pragma once

#include <vector>

namespace raycube::lidar {

/// sum_i w[i] f(x[i]) is the mean of f over a standard normal x; exact for polynomials up to degree 2n - 1. Ascending,
/// symmetric to the last bit, w sums to 1. A line of full width at half maximum F: wavelength = centre + x F / (2
/// sqrt(2 ln 2)).
struct HermiteRule {
  std::vector<double> x, w;
};

/// 1 <= n <= 200. Golub & Welsch, Math. Comp. 23 (1969) 221, nodes refined by Newton; weights are relative-accurate in
/// the tails too.
HermiteRule gauss_hermite(int n);

}  // namespace raycube::lidar
