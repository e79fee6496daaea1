// What matter sends by itself along paths between surfaces: as its excess over the surroundings, which stand for all
// that hides the sky (plan::Thermal).
#pragma once

#include <vector>

#include "host/plan/plan.h"

namespace raycube::plan {

/// B at the temperature of the hottest used material, W m-2 sr-1 um-1, [grid]; 0 without thermal light.
std::vector<double> hottest_light(const Plan& plan, const scene::CompiledScene& scene);

/// Below it sources have no share of the light together, and heat has none.
double least_light(const std::vector<double>& together);

/// Of a black body, at the sensor over `together` (Bounces::together at the middle of heights and views), [grid].
struct PathHeat {
  /// At the temperature of the surroundings; empty without thermal light.
  std::vector<double> surroundings;
  /// At that of each material less that of the surroundings; empty for those that the scene does not use.
  std::vector<std::vector<double>> excess;
  bool any() const { return !surroundings.empty(); }
};
PathHeat path_heat(const Plan& plan, const scene::CompiledScene& scene, const std::vector<double>& together);

}  // namespace raycube::plan
