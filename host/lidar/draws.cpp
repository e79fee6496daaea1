#include "host/lidar/draws.h"

#include <math.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/sampling/sampler.h"

namespace raycube::lidar {

namespace {

double log_factorial(double k) {
  int sign = 0;  // std::lgamma writes a global
  return ::lgamma_r(k + 1, &sign);
}

/// Ratio of two polynomials of degree 7, coefficients from the constant upwards.
double ratio(double x, const std::array<double, 8>& above, const std::array<double, 8>& below) {
  double a = above[7], b = below[7];
  for (std::size_t i = 7; i-- > 0;) a = a * x + above[i], b = b * x + below[i];
  return a / b;
}

}  // namespace

DrawSeed::DrawSeed(std::uint64_t seed)
    : bits_(rc_hash(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), 0x1DA5u, 0x4C49u)) {}

Stream::Stream(DrawSeed seed, std::uint32_t key, std::uint32_t index, DrawFor purpose, int line)
    : seed_(seed.bits()),
      key_(key),
      index_(index),
      counter_((static_cast<std::uint32_t>(line) * 16u + static_cast<std::uint32_t>(purpose)) << 16) {}

double Stream::uniform() {
  const std::uint64_t high = rc_hash(seed_, key_, index_, counter_),
                      low = rc_hash(seed_ ^ 0x9E3779B9u, key_, index_, counter_);
  counter_ = (counter_ & 0xFFFF0000u) | ((counter_ + 1) & 0xFFFFu);
  return (static_cast<double>(((high << 32 | low) >> 11)) + 0.5) * 0x1p-53;
}

double Stream::normal() {
  const double u = uniform(), q = u - 0.5;
  if (std::abs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q *
           ratio(r,
                 {3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3, 1.3731693765509461125e4,
                  4.5921953931549871457e4, 6.7265770927008700853e4, 3.3430575583588128105e4, 2.5090809287301226727e3},
                 {1.0, 4.2313330701600911252e1, 6.8718700749205790830e2, 5.3941960214247511077e3,
                  2.1213794301586595867e4, 3.9307895800092710610e4, 2.8729085735721942674e4, 5.2264952788528545610e3});
  }
  const double r = std::sqrt(-std::log(q < 0 ? u : 1 - u));
  const double z = r <= 5 ? ratio(r - 1.6,
                                  {1.42343711074968357734e0, 4.63033784615654529590e0, 5.76949722146069140550e0,
                                   3.64784832476320460504e0, 1.27045825245236838258e0, 2.41780725177450611770e-1,
                                   2.27238449892691845833e-2, 7.74545014278341407640e-4},
                                  {1.0, 2.05319162663775882187e0, 1.67638483018380384940e0, 6.89767334985100004550e-1,
                                   1.48103976427480074590e-1, 1.51986665636164571966e-2, 5.47593808499534494600e-4,
                                   1.05075007164441684324e-9})
                          : ratio(r - 5,
                                  {6.65790464350110377720e0, 5.46378491116411436990e0, 1.78482653991729133580e0,
                                   2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                   2.71155556874348757815e-5, 2.01033439929228813265e-7},
                                  {1.0, 5.99832206555887937690e-1, 1.36929880922735805310e-1, 1.48753612908506148525e-2,
                                   7.86869131145613259100e-4, 1.84631831751005468180e-5, 1.42151175831644588870e-7,
                                   2.04426310338993978564e-15});
  return q < 0 ? -z : z;
}

double Stream::exponential() { return -std::log(uniform()); }

double Stream::gamma(double shape) {
  if (shape < 1) {
    const double raised = gamma(shape + 1);
    return raised * std::pow(uniform(), 1 / shape);
  }
  const double d = shape - 1.0 / 3, c = 1 / std::sqrt(9 * d);
  for (;;) {
    const double x = normal(), root = 1 + c * x, u = uniform();
    if (root <= 0) continue;
    const double v = root * root * root;
    if (std::log(u) < 0.5 * x * x + d * (1 - v + std::log(v))) return d * v;
  }
}

double Stream::poisson(double mean) {
  if (std::isnan(mean)) return mean;
  if (!(mean > 0)) return 0;
  if (mean > 1e6) return std::max(0.0, std::round(mean + std::sqrt(mean) * normal()));
  if (mean < 10) {
    const double u = uniform();
    if (u <= 1 - mean) return 0;  // below exp(-mean)
    double term = std::exp(-mean), sum = term, k = 0;
    for (; u > sum && k < 1000; sum += term) term *= mean / ++k;
    return k;
  }
  const double b = 0.931 + 2.53 * std::sqrt(mean), a = -0.059 + 0.02483 * b,
               inverse_alpha = 1.1239 + 1.1328 / (b - 3.4), v_r = 0.9277 - 3.6224 / (b - 2);
  for (;;) {
    const double u = uniform() - 0.5, v = uniform(), us = 0.5 - std::abs(u),
                 k = std::floor((2 * a / us + b) * u + mean + 0.43);
    if (us >= 0.07 && v <= v_r) return k;
    if (k < 0 || (us < 0.013 && v > us)) continue;
    if (std::log(v * inverse_alpha / (a / (us * us) + b)) <= k * std::log(mean) - mean - log_factorial(k)) return k;
  }
}

double Stream::negative_binomial(double mean, double modes) {
  return poisson(modes > 0 && mean > 0 ? mean / modes * gamma(modes) : mean);
}

}  // namespace raycube::lidar
