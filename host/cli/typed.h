// Numbers that a user may type.
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace raycube::cli {

/// An option that was not typed.
inline constexpr double kUnset = std::numeric_limits<double>::quiet_NaN();

/// What was typed, in units of `factor`, replaces what stands.
inline void replace(double& standing, double typed, double factor = 1) {
  if (!std::isnan(typed)) standing = factor * typed;
}

/// The whole text as a finite number. Throws Error(input) that names the option.
double number_of(const std::string& text, const std::string& option);

/// Numbers between commas, of all uses of an option, ascending.
std::vector<double> numbers_of(const std::vector<std::string>& texts, const std::string& option);

}  // namespace raycube::cli
