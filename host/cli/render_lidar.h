// One LIDAR of a simulation, from shots to products.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/cli/simulation_job.h"
#include "host/cli/verb.h"
#include "scene_compiler/simulation.h"

namespace raycube::cli {

/// Fires every pulse of the survey, batch by batch: shots, turbulence, background light, expectations, detection,
/// products in `folder`. Sub-rays that the file does not give are the planner's, or those of the plan that is replayed.
/// Memory does not grow with the number of pulses. Returns what `render --json` says of it.
nlohmann::json render_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, const std::string& folder,
                            double load_s, Context& context, const Planning& planning);

/// What `render --dry-run` says: pulses, rays, rows, bytes of the products.
nlohmann::json dry_run_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Context& context,
                             const Planning& planning);

/// The same for people.
std::string dry_run_lidar_text(const nlohmann::json& item);

}  // namespace raycube::cli
