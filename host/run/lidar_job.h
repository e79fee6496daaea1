// What a run of a LIDAR does first: its air and its plan.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "host/run/services.h"
#include "host/lidar/lidar_plan.h"
#include "host/planner/lidar_own_error.h"
#include "host/planner/lidar_trial.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {
struct PlanFile;
}

namespace raycube::run {

/// How the planner settles the sub-rays where the file leaves them open.
struct LidarPlanning {
  render::LidarRenderer* renderer = nullptr;  ///< for its trial; null: no trial, the default stays
  const planner::PlanFile* replay = nullptr;  ///< instead of a trial; with the path it was read from
  std::string replay_path;
  bool estimate_given = false;
  /// Where no trial was made: whether pulses are fired to know the run's error, which echo finders are told.
  bool own_error = false;
};

struct LidarJob {
  const scene::Lidar* lidar = nullptr;  ///< as the file has it; the plan's own has the planner's sub-rays
  lidar::LidarPlan plan;
  planner::LidarDecision decision;
  planner::LidarOwnError error;
  std::string air_json;                  ///< what the air was made of; empty: none
  std::vector<std::string> air_notices;  ///< of the air; the log has them
  double table_s = 0, plan_s = 0;
};

/// Air profiles of the layered model at the laser's wavelengths; none: no air. Throws Error(input) when the file's air
/// has no profiles for pulses, or is not one.
std::unique_ptr<atmos::RenderTable> lidar_air(const scene::Simulation& simulation, const scene::Lidar& lidar);

/// The air, then the plan.
LidarJob prepare_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Services& services,
                       const LidarPlanning& planning = {});

/// The planner's decision and its lines, for a file.
nlohmann::json plan_json(const LidarJob& job);

}  // namespace raycube::run
