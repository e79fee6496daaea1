#include "host/planner/error_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raycube::planner {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

/// A straight line of the logarithms, at t of the way; where an error is 0 the larger of both holds, which is careful.
std::vector<double> between(const std::vector<double>& below, const std::vector<double>& above, double t) {
  std::vector<double> out(below.size());
  for (std::size_t b = 0; b < out.size(); ++b)
    out[b] = below[b] > 0 && above[b] > 0 ? below[b] * std::pow(above[b] / below[b], t) : std::max(below[b], above[b]);
  return out;
}

}  // namespace

void ErrorLaw::measured(double level, BandErrors errors) {
  const auto above = points_.lower_bound(level);
  for (std::size_t b = 0; b < errors.bound.size(); ++b) {
    if (above != points_.begin()) {
      const auto& [smaller, point] = *std::prev(above);
      errors.bound[b] = std::min(errors.bound[b], point.bound[b] * std::pow(smaller / level, exponents_.beyond));
    }
    errors.bound[b] = std::max(errors.estimate[b], errors.bound[b]);
  }
  points_[level] = std::move(errors);
  for (auto larger = std::prev(points_.end()); larger != points_.begin(); --larger) {
    auto& [smaller, point] = *std::prev(larger);
    const double rise = std::pow(larger->first / smaller, exponents_.hope_below);
    for (std::size_t b = 0; b < point.bound.size(); ++b)
      point.bound[b] = std::max(point.bound[b], larger->second.bound[b] * rise);
  }
}

BandErrors ErrorLaw::hoped(double level) const {
  if (has(level) || empty()) return errors(level);
  BandErrors least;
  least.estimate.assign(points_.begin()->second.estimate.size(), kInfinity);
  least.bound = least.estimate;
  const auto may_fall_to = [&](const BandErrors& point, double factor) {
    for (std::size_t b = 0; b < least.estimate.size(); ++b) {
      least.estimate[b] = std::min(least.estimate[b], point.estimate[b] * factor);
      least.bound[b] = std::min(least.bound[b], point.bound[b] * factor);
    }
  };
  for (const auto& [measured, point] : points_)
    may_fall_to(point, std::pow(measured / level, measured < level ? exponents_.hope : exponents_.hope_before));
  if (level < smallest()) may_fall_to(points_.begin()->second, std::pow(smallest() / level, exponents_.hope_below));
  return least;
}

BandErrors ErrorLaw::errors(double level) const {
  if (points_.empty()) return {{kInfinity}, {kInfinity}};
  const auto above = points_.lower_bound(level);
  if (above != points_.end() && above->first == level) return above->second;
  if (above == points_.begin() || above == points_.end()) {
    const auto& [measured, point] = above == points_.begin() ? *above : *std::prev(above);
    const double factor = std::pow(measured / level, measured > level ? exponents_.before : exponents_.beyond);
    return {scaled(point.estimate, factor), scaled(point.bound, factor)};
  }
  const auto& [smaller, below] = *std::prev(above);
  const double t = std::log(level / smaller) / std::log(above->first / smaller);
  return {between(below.estimate, above->second.estimate, t), between(below.bound, above->second.bound, t)};
}

}  // namespace raycube::planner
