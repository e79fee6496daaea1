// A curve of transmittance against amount as a sum of few exponentials.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::atmos {

struct ExponentialSum {
  std::vector<double> weight;  ///< >= 0, sum 1
  std::vector<double> rate;    ///< > 0, falling
  double at(double amount) const;
};

/// Least squares fit of sum_j weight_j exp(-rate_j amount) to transmittance (0..1, falling) at amounts (> 0,
/// ascending), residuals times `importance`. At most `terms` >= 1 terms. Non-negative least squares (Lawson & Hanson
/// 1974) on a logarithmic grid of rates, neighbours merged until `terms` remain, then rates by Gauss-Newton with the
/// weights solved anew at each step (variable projection, Golub & Pereyra 1973).
ExponentialSum fit_exponential_sum(const std::vector<double>& amount, const std::vector<double>& transmittance,
                                   const std::vector<double>& importance, std::size_t terms);

}  // namespace raycube::atmos
