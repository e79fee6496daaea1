// Where a chi-squared statistic is as unusual as a Gaussian so many deviations out.
#pragma once

#include <cmath>

namespace raycube::testing {

/// Wilson and Hilferty (1931): of few degrees of freedom, f + 4 sqrt(2 f) is passed by one draw in two hundred.
inline double chi_square_limit(double freedom, double deviations) {
  const double each = 2 / (9 * freedom);
  return freedom * std::pow(1 - each + deviations * std::sqrt(each), 3);
}

}  // namespace raycube::testing
