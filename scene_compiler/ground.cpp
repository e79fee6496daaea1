#include "scene_compiler/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace raycube::scene {

double Ground::z_m(double x_m, double y_m) const {
  std::optional<double> highest;
  for (const auto& terrain : terrains_)
    if (const auto z = terrain.height_m(x_m, y_m); z && (!highest || *z > *highest)) highest = z;
  if (highest) return *highest;
  double nearest_m = std::numeric_limits<double>::infinity(), at_edge_m = 0;
  for (const auto& terrain : terrains_) {
    const auto [edge_x, edge_y] = terrain.nearest(x_m, y_m);
    const double away_m = std::hypot(edge_x - x_m, edge_y - y_m);
    if (const auto z = terrain.height_m(edge_x, edge_y); z && away_m < nearest_m) nearest_m = away_m, at_edge_m = *z;
  }
  return at_edge_m;
}

}  // namespace raycube::scene
