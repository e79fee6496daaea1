#include "host/lidar/incomplete_gamma.h"

#include <math.h>

#include <cmath>

namespace raycube::lidar {

double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

double gamma_p(double a, double x) {
  if (!(x > 0)) return 0;
  const double scale = std::exp(a * std::log(x) - x - log_gamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (double n = a + 1; term > 1e-16 * sum; ++n) sum += term *= x / n;
    return scale * sum;
  }
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int i = 1; i < 10000; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = 1 / (an * d + b), c = b + an / c, h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return 1 - scale * h;
}

}  // namespace raycube::lidar
