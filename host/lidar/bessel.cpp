#include "host/lidar/bessel.h"

#include <cmath>

namespace raycube::lidar {

double scaled_bessel_i0(double x) {
  if (x < 30) {
    // Power series, Abramowitz & Stegun 9.6.12: every term is positive.
    double term = 1, sum = 1;
    for (int k = 1; term > 1e-17 * sum; ++k) sum += term *= 0.25 * x * x / (static_cast<double>(k) * k);
    return std::exp(-x) * sum;
  }
  // Asymptotic series, Abramowitz & Stegun 9.7.1; its smallest term at x = 30 is near exp(-60).
  double term = 1, sum = 1;
  for (int k = 1; k < 40 && term > 1e-17; ++k) sum += term *= (2 * k - 1.0) * (2 * k - 1.0) / (8 * k * x);
  return sum / std::sqrt(2 * M_PI * x);
}

}  // namespace raycube::lidar
