// How alike two cubes of one kind of scene are: the scorecard of [B]'s comparisons (docs/analysis.md).
#pragma once

#include <string>
#include <vector>

#include "host/analysis/cube.h"
#include "host/analysis/eigen_structure.h"
#include "host/analysis/moments.h"

namespace raycube::analysis {

/// Two cubes' pixels of some bands, drawn evenly, sorted: for comparing distributions.
class SortedBands {
 public:
  /// At most `most` pixels of those that count, every so many-th.
  SortedBands(const Cube& cube, const Pass& pass, std::size_t most = 100000);
  const std::vector<double>& band(std::size_t b) const { return band_[b]; }

 private:
  std::vector<std::vector<double>> band_;
};

/// Largest distance between two distribution functions (Kolmogorov & Smirnov's D), of sorted numbers.
double largest_distance(const std::vector<double>& a, const std::vector<double>& b);

/// A line of the scorecard. alike: what it is where the two are the same.
struct Score {
  std::string name, unit;
  double value = 0, alike = 0;
};

/// Of two cubes with the same bands: means, spreads, distributions, eigenstructure. `count`: eigenvectors.
std::vector<Score> likeness(const Moments& of_a, const SortedBands& sorted_a, const Moments& of_b,
                            const SortedBands& sorted_b, std::size_t count);

}  // namespace raycube::analysis
