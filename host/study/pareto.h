// Which settings nothing beats in both time and error.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::study {

struct Cost {
  double time = 0, error = 0;
};

/// Indices of the points that no other point beats: no other is as good in both and better in one. By time, then error.
/// Points that are not finite are never on the front; of equal points the first is.
std::vector<std::size_t> pareto_front(const std::vector<Cost>& points);

}  // namespace raycube::study
