#include "atmos_tables/aerosol/phase_function.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "atmos_tables/optics/gauss_legendre.h"
#include "host/base/error.h"

namespace raycube::atmos {

PhaseFunction::PhaseFunction(std::vector<Part> parts) : parts_(std::move(parts)) {
  double sum = 0;
  bool good = !parts_.empty();
  for (const Part& part : parts_) {
    good = good && part.shape && part.weight >= 0;
    sum += part.weight;
  }
  if (!good || !(std::abs(sum - 1) <= 1e-9))
    throw base::Error(base::Fault::bug, "phase function: weights of a mixture must not be negative and sum to 1");
}

PhaseFunction PhaseFunction::henyey_greenstein(double g) {
  if (!(std::abs(g) < 1))
    throw base::Error(base::Fault::input,
                      "Henyey-Greenstein: the asymmetry must lie inside -1..1 (found " + std::to_string(g) + ")");
  PhaseFunction out;
  out.g_ = g;
  return out;
}

PhaseFunction PhaseFunction::of_moments(std::vector<double> moments) {
  if (moments.empty() || moments[0] != 1)
    throw base::Error(base::Fault::bug, "phase function: the moment of order 0 must be 1");
  PhaseFunction out;
  out.moments_ = std::move(moments);
  return out;
}

PhaseFunction PhaseFunction::mixture(const PhaseFunction& a, double weight_a, const PhaseFunction& b, double weight_b) {
  if (a.parts_.empty() || b.parts_.empty())
    throw base::Error(base::Fault::bug, "phase function: only tabulated ones are mixed");
  std::vector<Part> parts;
  for (const Part& part : a.parts_) parts.push_back({weight_a * part.weight, part.shape});
  for (const Part& part : b.parts_) parts.push_back({weight_b * part.weight, part.shape});
  return PhaseFunction(std::move(parts));
}

double PhaseFunction::value(double cos_angle) const {
  if (!moments_.empty()) return std::max(0.0, legendre_series(moments_, cos_angle));
  if (parts_.empty()) {
    const double root = std::sqrt(1 + g_ * g_ - 2 * g_ * cos_angle);
    return (1 - g_ * g_) / (root * root * root);
  }
  double out = 0;
  for (const Part& part : parts_)
    out += part.weight * (cos_angle <= -1 ? part.shape->backward() : part.shape->value(cos_angle));
  return out;
}

std::vector<double> PhaseFunction::moments(std::size_t last) const {
  std::vector<double> out(last + 1, 0);
  if (!moments_.empty()) {
    std::copy_n(moments_.begin(), std::min(moments_.size(), last + 1), out.begin());
    return out;
  }
  if (parts_.empty()) {
    double power = 1;
    for (double& moment : out) moment = power, power *= g_;
    return out;
  }
  for (const Part& part : parts_) {
    const std::vector<double> one = part.shape->moments(last);
    for (std::size_t k = 0; k <= last; ++k) out[k] += part.weight * one[k];
  }
  return out;
}

double PhaseFunction::asymmetry() const {
  if (!moments_.empty()) return moments_.size() > 1 ? moments_[1] : 0;
  if (parts_.empty()) return g_;
  double out = 0;
  for (const Part& part : parts_) out += part.weight * part.shape->asymmetry();
  return out;
}

}  // namespace raycube::atmos
