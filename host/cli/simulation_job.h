// What `render` and `check` do first: a simulation file to a scene, and for each instrument its atmosphere table and plan.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/cli/verb.h"
#include "host/plan/plan.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::cli {

/// Loads the file; notices go to the log. Throws Error(input) with every problem found.
scene::Simulation load_job(const std::string& file, Context& context);

/// The passive instruments called `name`, or all when it is empty. Throws Error(input) that lists instruments and LIDARs when neither has
/// one of that name.
std::vector<const scene::Instrument*> pick_instruments(const scene::Simulation& simulation, const std::string& name);

/// What one instrument's render needs besides the scene.
struct InstrumentJob {
  const scene::Instrument* instrument = nullptr;
  atmos::RenderTable table;
  plan::Plan plan;
  double table_s = 0, plan_s = 0;
};

/// Reads or builds the table for the instrument's height and bands, then plans.
InstrumentJob prepare(const scene::Simulation& simulation, const scene::Instrument& instrument, Context& context);

render::RenderOptions render_options(const CommonOptions& common);

}  // namespace raycube::cli
