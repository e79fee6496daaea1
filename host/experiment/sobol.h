// Sobol's sequence, and variance-based indices from runs on it.
#pragma once

#include <cstdint>
#include <vector>

namespace raycube::experiment {

inline constexpr int kMostDimensions = 20;

/// Coordinate of a point of Sobol's sequence in [0, 1), dimensions from 0: directions of Joe and Kuo (2008, SIAM J.
/// Sci. Comput. 30, 2635), points in the order of Gray's code as Antonov and Saleev have it (scipy's, unscrambled).
double sobol_coordinate(std::uint32_t point, int dimension);

/// Rows of a run for indices of k parameters by N base points: A, B, then A with the i-th column of B, i = 0 .. k - 1
/// (N rows each). A: dimensions 0 .. k - 1 of the sequence, B: the next k, from its point 1 on.
std::vector<std::vector<double>> sobol_rows(std::uint32_t base_points, int parameters);

struct SobolIndex {
  double first = 0, first_low = 0, first_high = 0;  ///< share of the variance by itself, and an interval of 95 %
  double total = 0, total_low = 0, total_high = 0;  ///< with all that it acts together with
};

/// From what those rows gave, in their order. First order: Saltelli et al. (2010, Comput. Phys. Commun. 181, 259) table
/// 2 (b), of values about their mean; total: Jansen's (f) there. Intervals by a bootstrap over base points, drawn by a
/// counter. All NaN where the values do not vary.
std::vector<SobolIndex> sobol_indices(const std::vector<double>& value, std::uint32_t base_points, int parameters);

}  // namespace raycube::experiment
