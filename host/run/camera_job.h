// What a run of a camera does first: its atmosphere table and plan.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/run/air_table.h"
#include "host/run/services.h"
#include "host/plan/one_direction.h"
#include "host/plan/plan.h"
#include "host/planner/planner.h"
#include "host/render/renderer.h"
#include "host/sensors/cells.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {
struct PlanFile;
}

namespace raycube::run {

/// Of the scene, below the sensor; 0 where it is empty.
plan::HeightRange seen_heights(const scene::CompiledScene& scene, const plan::ViewBounds& view);

/// How the planner settles what the file leaves open.
struct Planning {
  render::Renderer* renderer = nullptr;       ///< for its trial; null: no trial, the defaults stay
  const planner::PlanFile* replay = nullptr;  ///< instead of a trial; with the path it was read from
  std::string replay_path;
  bool estimate_given = false;  ///< a trial even where the file gives everything
};

/// What one instrument's render needs besides the scene.
struct CameraJob {
  std::shared_ptr<const sensors::Cells> cells;       ///< of a camera with focal planes: what is rendered; else null
  std::shared_ptr<const scene::Instrument> planned;  ///< with the planner's samples
  const scene::Instrument* instrument = nullptr;     ///< the same
  planner::Decision decision;
  atmos::RenderTable table;
  plan::Plan plan;
  std::vector<std::string> notices;  ///< of table and instrument together; the log has them
  /// Whose image it becomes.
  const scene::Instrument& image() const { return cells ? cells->seen : *instrument; }
  double table_s = 0, kernels_s = 0, plan_s = 0, plan_processor_s = 0;  ///< kernels: built, or taken from the cache
};

/// The air that an instrument's bands and height ask for, over the scene's heights.
AirRequest air_request(const scene::Simulation& simulation, const scene::Instrument& instrument,
                       double sensor_height_m);

/// Reads or builds the table for the instrument's height and bands, then plans; the planner's notes go to the log.
CameraJob prepare_camera(const scene::Simulation& simulation, const scene::Instrument& instrument, Services& services,
                         const Planning& planning = {});

/// The plan that a render goes by: with the truth per band that the instrument asks for. Outlives the job's only where
/// there is some.
std::shared_ptr<const plan::Plan> render_plan(const CameraJob& job);

/// The plan with the planner's decision, for a file.
nlohmann::json plan_json(const CameraJob& job);

}  // namespace raycube::run
