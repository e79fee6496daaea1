// Points inside the layers of a column at which amounts of absorbers are summed.
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

struct LayerNode {
  std::size_t layer = 0;
  double length_km = 0;  ///< weight; those of a layer sum to its thickness
  AirLevel air;
};

/// Four Gauss points in every piece between levels of the layers and levels of the profile, where all quantities are
/// smooth: the column of an exponential density that falls 100-fold in a piece is right to 1e-4, 10-fold to 1e-7.
/// Throws Error(input) that lists every fault: fewer than 2 levels, levels that do not ascend strictly or lie outside
/// the profile. points: Gauss points in a piece, where four are more than needed.
std::vector<LayerNode> layer_nodes(const AirProfile& profile, const std::vector<double>& level_km,
                                   std::size_t points = 4);

}  // namespace raycube::atmos
