#include "host/planner/error_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raycube::planner {

void ErrorLaw::measured(double level, double estimate, double bound) {
  const auto above = points_.lower_bound(level);
  if (above != points_.begin()) {
    const auto& [smaller, point] = *std::prev(above);
    bound = std::min(bound, point.bound * std::pow(smaller / level, exponents_.beyond));
  }
  points_[level] = {estimate, std::max(estimate, bound)};
}

double ErrorLaw::hope(double level) const {
  if (has(level) || empty()) return bound(level);
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [measured, point] : points_)
    least = std::min(least, point.estimate * std::pow(measured / level,
                                                      measured < level ? exponents_.hope : exponents_.hope_before));
  if (level < smallest())
    least = std::min(least, points_.begin()->second.estimate * std::pow(smallest() / level, exponents_.hope_below));
  return least;
}

double ErrorLaw::at(double level, double Point::*what) const {
  if (points_.empty()) return std::numeric_limits<double>::infinity();
  const auto value = [&](auto i) { return i->second.*what; };
  const auto above = points_.lower_bound(level);
  if (above != points_.end() && above->first == level) return value(above);
  if (above == points_.begin()) return value(above) * std::pow(above->first / level, exponents_.before);
  const auto below = std::prev(above);
  if (above == points_.end()) return value(below) * std::pow(below->first / level, exponents_.beyond);
  // A straight line of the logarithms; where an error is 0 the smaller level's holds, which is careful.
  if (!(value(below) > 0) || !(value(above) > 0)) return std::max(value(below), value(above));
  const double t = std::log(level / below->first) / std::log(above->first / below->first);
  return std::pow(value(below), 1 - t) * std::pow(value(above), t);
}

}  // namespace raycube::planner
