#include "host/plan/given_levels.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "host/plan/plan.h"
#include "host/plan/sky_rays.h"

namespace raycube::plan {
namespace {

/// " (sky_rank 1, view_nodes 7)".
std::string describe_given(const scene::PlanOverrides& given) {
  std::string out;
  for (const auto& [key, value] : given_overrides(given))
    out += fmt::format("{}{} {}", out.empty() ? " (" : ", ", key, value);
  return out + ")";
}

}  // namespace

base::Error impossible_levels(const scene::Simulation& simulation) {
  return base::Error(base::Fault::input,
                     fmt::format("{}: [plan] asks for what no plan can have{}: more than {} channels, or a sky of so "
                                 "few components that it takes away more than there is; give fewer nodes, another "
                                 "sky_rank, or remove a key",
                                 simulation.file, describe_given(simulation.plan), RC_MAX_CHANNELS));
}

void check_given_levels(const scene::Simulation& simulation) {
  if (simulation.sky_directions < 1 || simulation.sky_directions > kMostSkyRays)
    throw base::Error(base::Fault::input,
                      fmt::format("{}: sky_directions must be 1 to {} (found {}); without it the planner chooses",
                                  simulation.file, kMostSkyRays, simulation.sky_directions));
  // As choose_nodes counts channels, of one source and with one node where the file does not say.
  const scene::PlanOverrides& given = simulation.plan;
  const int height = std::max(1, given.height_nodes), view = std::max(1, given.view_nodes),
            path = std::max(1, given.path_nodes);
  if (height * view > RC_MAX_CHANNELS || height * path * path > RC_MAX_CHANNELS) throw impossible_levels(simulation);
}

}  // namespace raycube::plan
