// The pulse's shares of bins as polynomials of the place within a bin, for many rays that fall into the same bins.
#pragma once

#include <vector>

#include "host/lidar/lidar_plan.h"
#include "kernels/lidar/layout.h"

namespace raycube::lidar {

/// A bin is cut into `cells` of equal width. A hit of energy e at phase f (0 <= f < 1) of its bin lies in cell
/// c = floor(f cells), at y = f cells - c - 1/2, and adds e sum_k share[c][k][i] y^k to tap i of PulseTaps: so that of
/// many hits in one cell only the moments sum e y^k, k < RC_MOMENTS, are needed.
struct PulseMoments {
  int cells = 0;             ///< 0: the pulse has corners, or is too short against a bin
  std::vector<float> share;  ///< [cells][RC_MOMENTS][taps]
};

/// Through RC_MOMENTS of the table's phases in each cell, near Chebyshev's; as many cells (a power of two, at most 16)
/// as it takes to meet every phase of the table to 2e-6 of the largest share, which is what the table itself holds
/// between its phases, and none below 0. Energy is kept as the table keeps it.
PulseMoments make_moments(const PulseTaps& taps);

}  // namespace raycube::lidar
