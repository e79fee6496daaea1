#include "atmos_tables/gas/layer_nodes.h"

#include <algorithm>
#include <string>

#include "atmos_tables/optics/gauss_legendre.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

void check(const AirProfile& profile, const std::vector<double>& level_km) {
  base::Problems problems;
  const auto place = [&](std::size_t i) {
    return base::Where{profile.source(), 0, 0, "layer level " + std::to_string(i + 1)};
  };
  if (level_km.size() < 2)
    problems.add({profile.source(), 0, 0, ""}, "layers need at least 2 levels", std::to_string(level_km.size()),
                 "add levels");
  for (std::size_t i = 0; i < level_km.size(); ++i) {
    if (!(level_km[i] >= profile.ground_km() && level_km[i] <= profile.top_km()))
      problems.add(place(i),
                   "level must lie inside the profile, " + std::to_string(profile.ground_km()) + " to " +
                       std::to_string(profile.top_km()) + " km",
                   std::to_string(level_km[i]), "move the level or give a taller profile");
    if (i > 0 && !(level_km[i] > level_km[i - 1]))
      problems.add(place(i), "levels must ascend strictly", std::to_string(level_km[i]), "sort the levels");
  }
  problems.throw_if_any();
}

}  // namespace

std::vector<LayerNode> layer_nodes(const AirProfile& profile, const std::vector<double>& level_km, std::size_t points) {
  check(profile, level_km);
  const GaussRule rule = gauss_legendre_rule(points);
  std::vector<LayerNode> nodes;
  for (std::size_t layer = 0; layer + 1 < level_km.size(); ++layer) {
    std::vector<double> edges = {level_km[layer], level_km[layer + 1]};
    for (const AirLevel& level : profile.levels())
      if (level.height_km > edges.front() && level.height_km < level_km[layer + 1]) edges.push_back(level.height_km);
    std::sort(edges.begin(), edges.end());
    for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
      const double half = 0.5 * (edges[e + 1] - edges[e]);
      for (std::size_t k = 0; k < rule.node.size(); ++k)
        nodes.push_back({layer, half * rule.weight[k], profile.at(edges[e] + half * (1 + rule.node[k]))});
    }
  }
  return nodes;
}

}  // namespace raycube::atmos
