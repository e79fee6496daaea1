// What `render` and `check` do first for a LIDAR: its air and its plan; and the light of sun and sky in its field of view.
#pragma once

#include <memory>
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
  const scene::Lidar* lidar = nullptr;        ///< as the file has it; the plan's own has the planner's sub-rays
  lidar::LidarPlan plan;
  planner::LidarDecision decision;
  std::string plan_json;                      ///< the decision and its lines
  std::string air_json;                       ///< what the air was made of; empty: none
  double table_s = 0, plan_s = 0;
};

/// Throws Error(input) when the file's air has no profiles for pulses.
void check_lidar_air(const scene::Simulation& simulation, const scene::Lidar& lidar);

/// Air profiles of the layered model at the laser's wavelengths (none: no air; clear_sky has no profiles and is refused), then the plan.
LidarJob prepare_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Context& context, const LidarPlanning& planning = {});

/// The LIDARs called `name`, or all when it is empty; none is no error.
std::vector<const scene::Lidar*> pick_lidars(const scene::Simulation& simulation, const std::string& name);

/// Sun and sky reflected by the scene, seen by the receiver through each line's filter: the passive renderer with one pixel for each
/// field of view. A round field is a square of the same solid angle; 3 x 3 samples a pixel.
class LidarBackground {
 public:
  LidarBackground(const scene::Simulation& simulation, const lidar::LidarPlan& plan, const render::RenderOptions& options, Context& context);
  ~LidarBackground();

  /// Photons / s at the detector, [shot][pixel][line].
  std::vector<std::vector<double>> rates(const std::vector<lidar::Shot>& shots);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::cli
