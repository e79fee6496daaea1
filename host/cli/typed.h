// Numbers that a user may type.
#pragma once

#include <cmath>
#include <limits>

namespace raycube::cli {

/// An option that was not typed.
inline constexpr double kUnset = std::numeric_limits<double>::quiet_NaN();

/// What was typed, in units of `factor`, replaces what stands.
inline void replace(double& standing, double typed, double factor = 1) {
  if (!std::isnan(typed)) standing = factor * typed;
}

}  // namespace raycube::cli
