// Linear weights of a value on an axis of the plan's nodes.
#pragma once

#include <algorithm>

#include "host/plan/plan.h"

namespace raycube::reference {

/// Node `low` takes 1 - f, the next one f.
struct NodeWeight {
  int low = 0;
  double f = 0;
  double of(int node) const { return node == low ? 1 - f : node == low + 1 ? f : 0; }
};

/// Held at the axis' ends.
inline NodeWeight locate(const plan::NodeAxis& axis, double value) {
  if (axis.count < 2) return {};
  const double last = axis.count - 1;
  const double t = std::clamp((value - static_cast<double>(axis.first)) / static_cast<double>(axis.step), 0.0, last);
  const int low = std::min(static_cast<int>(t), axis.count - 2);
  return {low, t - low};
}

}  // namespace raycube::reference
