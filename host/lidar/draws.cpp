#include "host/lidar/draws.h"

#include <math.h>

#include <algorithm>
#include <cmath>

#include "host/lidar/normal_quantile.h"
#include "kernels/sampling/sampler.h"

namespace raycube::lidar {

namespace {

double log_factorial(double k) {
  int sign = 0;  // std::lgamma writes a global
  return ::lgamma_r(k + 1, &sign);
}

}  // namespace

DrawSeed::DrawSeed(std::uint64_t seed)
    : bits_(rc_hash(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), 0x1DA5u, 0x4C49u)) {}

Stream::Stream(DrawSeed seed, std::uint32_t key, std::uint32_t index, DrawFor purpose, int line)
    : seed_(seed.bits()), key_(key), index_(index), counter_(first_counter(purpose, line)) {}

double Stream::uniform() {
  const std::uint64_t high = rc_hash(seed_, key_, index_, counter_),
                      low = rc_hash(seed_ ^ kLowBits, key_, index_, counter_);
  counter_ = (counter_ & 0xFFFF0000u) | ((counter_ + 1) & 0xFFFFu);
  return (static_cast<double>(((high << 32 | low) >> 11)) + 0.5) * 0x1p-53;
}

double Stream::normal() { return normal_quantile(uniform()); }

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
