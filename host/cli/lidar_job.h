// What `render` and `check` do first for a LIDAR: its air and its plan; and the light of sun and sky in its field of
// view.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "host/cli/verb.h"
#include "host/lidar/lidar_plan.h"
#include "host/planner/lidar_trial.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {
struct PlanFile;
}

namespace raycube::cli {

/// How the planner settles the sub-rays where the file leaves them open.
struct LidarPlanning {
  render::LidarRenderer* renderer = nullptr;  ///< for its trial; null: no trial, the default stays
  const planner::PlanFile* replay = nullptr;  ///< instead of a trial; with the path it was read from
  std::string replay_path;
  bool estimate_given = false;
};

struct LidarJob {
  const scene::Lidar* lidar = nullptr;  ///< as the file has it; the plan's own has the planner's sub-rays
  lidar::LidarPlan plan;
  planner::LidarDecision decision;
  std::string plan_json;                 ///< the decision and its lines
  std::string air_json;                  ///< what the air was made of; empty: none
  std::vector<std::string> air_notices;  ///< of the air; the log has them
  double table_s = 0, plan_s = 0;
};

/// Air profiles of the layered model at the laser's wavelengths; none: no air. Throws Error(input) when the file's air
/// has no profiles for pulses, or is not one.
std::unique_ptr<atmos::RenderTable> lidar_air(const scene::Simulation& simulation, const scene::Lidar& lidar);

/// The air, then the plan.
LidarJob prepare_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Context& context,
                       const LidarPlanning& planning = {});

/// The LIDARs called `name`, or all when it is empty; none is no error.
std::vector<const scene::Lidar*> pick_lidars(const scene::Simulation& simulation, const std::string& name);

/// Whether light of the scene falls on the detector besides the pulses': asked for, and by day, or warm enough to shine
/// itself.
bool has_background(const scene::Simulation& simulation, const scene::Lidar& lidar);
/// The camera whose pixels see what the receiver does: a round field is a square of the same solid angle; 3 x 3
/// samples a pixel; bands ascend as the lines' wavelengths. A line for each shot; of an array the first shot's image.
scene::Instrument background_camera(const lidar::LidarPlan& plan, std::span<const lidar::Shot> shots);

/// Sun and sky reflected by the scene, seen by the receiver through each line's filter: the passive renderer's
/// background_camera.
class LidarBackground {
 public:
  LidarBackground(const scene::Simulation& simulation, const lidar::LidarPlan& plan,
                  const render::RenderOptions& options, Context& context);
  ~LidarBackground();

  /// Photons / s at the detector, [shot][pixel][line].
  std::vector<std::vector<double>> rates(const std::vector<lidar::Shot>& shots);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::cli
