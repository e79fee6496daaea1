// Which rows of a table to keep so that the others lie about linearly between them.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::scene {

struct LinearNodes {
  std::vector<std::size_t> row;  ///< ascending; the first and the last row are kept
  double error = 0;              ///< rms of what lies between, over the rms of all values
};

/// Of rows at ascending x, all equally long, as many as it takes for `enough`, `most` (2 or more) at most: one after
/// the other where the error is largest, each then moved to where it is least.
LinearNodes linear_nodes(const std::vector<double>& x, const std::vector<std::vector<double>>& rows, std::size_t most,
                         double enough);

}  // namespace raycube::scene
