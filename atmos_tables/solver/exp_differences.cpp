#include "atmos_tables/solver/exp_differences.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raycube::atmos::solver {

double exp_mean(double x) {
  if (std::abs(x) < 1e-8) return 1 - 0.5 * x;  // the next term, x^2/6, is below 2e-17
  return -std::expm1(-x) / x;
}

double exp_difference(double x, double y) { return std::exp(-std::min(x, y)) * exp_mean(std::abs(y - x)); }

double exp_difference(double x, double y, double z) {
  if (x > y) std::swap(x, y);
  if (y > z) std::swap(y, z);
  if (x > y) std::swap(x, y);
  const double p = y - x, q = z - x;  // 0 <= p <= q: exp(-x) times the difference at 0, p, q
  if (q > 0.3) return std::exp(-x) * (exp_mean(p) - exp_difference(p, q)) / q;
  // Taylor: sum over n of (-1)^n h_n(p, q) / (n + 2)!, h_n the complete homogeneous polynomial; 0.3^13/15! is
  // below 2e-19.
  double sum = 0, homogeneous = 1, power = 1, factor = 0.5;
  for (int n = 0; n < 13; ++n) {
    sum += factor * homogeneous;
    power *= p;
    homogeneous = homogeneous * q + power;
    factor /= -(n + 3);
  }
  return std::exp(-x) * sum;
}

}  // namespace raycube::atmos::solver
