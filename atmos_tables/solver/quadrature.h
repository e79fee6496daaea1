// Double-Gauss quadrature: Gauss-Legendre nodes of each hemisphere by itself (Sykes 1951; Stamnes, Tsay,
// Wiscombe & Jayaweera 1988, Appl. Opt. 27, 2502, section II.B), because radiance may jump at the horizon.
#pragma once

#include <vector>

namespace raycube::atmos::solver {

/// Nodes (cosines, ascending, inside (0, 1)) and weights (sum 1) of one hemisphere.
struct HalfRange {
  std::vector<double> cosine, weight;
};

/// Exact for polynomials up to degree 2 count - 1 on [0, 1]. count >= 1 (half the number of streams).
HalfRange gauss_half_range(int count);

}  // namespace raycube::atmos::solver
