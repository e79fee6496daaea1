#include "host/cli/simulation_job.h"

#include <algorithm>
#include <chrono>
#include <tuple>

#include "atmos_tables/clear_sky_inputs.h"
#include "host/base/error.h"
#include "host/cli/air_table.h"
#include "host/plan/channel_bands.h"
#include "host/plan/one_direction.h"
#include "host/planner/plan_file.h"
#include "host/sensors/view_bounds.h"
#include "scene_compiler/load_simulation.h"

namespace raycube::cli {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

AirRequest air_request(const scene::Simulation& simulation, const scene::Instrument& instrument,
                       double sensor_height_m) {
  AirRequest request;
  request.spec = &simulation.atmosphere;
  request.sun = simulation.sun;
  request.sensor_height_m = sensor_height_m;
  std::tie(request.first_um, request.last_um) = band_range(instrument.bands);
  if (simulation.atmosphere.layered) request.step_um = simulation.atmosphere.layered->spectral_step_um;
  const auto& scene = simulation.scene;
  const bool empty = scene.instances.empty();
  request.low_m = empty ? 0.0 : scene.lo[2];
  request.high_m = empty ? 0.0 : std::min<double>(scene.hi[2], sensor_height_m);
  return request;
}

scene::Simulation load_job(const std::string& file, Context& context) {
  scene::LoadOptions options;
  options.seed = context.common.seed;
  options.need_instruments = true;
  scene::Simulation simulation = scene::load_simulation(file, options);
  for (const auto& notice : simulation.notices) context.log.warning(notice);
  for (const auto& instrument : simulation.instruments)
    for (const auto& notice : light_notices(simulation, instrument))
      context.log.warning(instrument.name + ": " + notice);
  for (const auto& lidar : simulation.lidars)
    for (const auto& notice : light_notices(simulation, lidar)) context.log.warning(lidar.name + ": " + notice);
  return simulation;
}

std::vector<std::string> light_notices(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  if (instrument.bands.empty()) return {};
  const auto notice = atmos::no_light_notice(simulation.atmosphere, simulation.sun, band_range(instrument.bands).first);
  return notice ? std::vector{*notice} : std::vector<std::string>{};
}

std::vector<std::string> light_notices(const scene::Simulation& simulation, const scene::Lidar& lidar) {
  if (!lidar.detector.solar_background || lidar.pulse.lines.empty()) return {};
  double first_um = lidar.pulse.lines[0].wavelength_um;
  for (const auto& line : lidar.pulse.lines) first_um = std::min(first_um, line.wavelength_um);
  const auto notice = atmos::no_light_notice(simulation.atmosphere, simulation.sun, first_um);
  return notice ? std::vector{"the background of scene and sky (solar_background): " + *notice}
                : std::vector<std::string>{};
}

std::vector<const scene::Instrument*> pick_instruments(const scene::Simulation& simulation, const std::string& name) {
  std::vector<const scene::Instrument*> picked;
  std::string known;
  for (const auto& instrument : simulation.instruments) {
    if (name.empty() || instrument.name == name) picked.push_back(&instrument);
    known += (known.empty() ? "" : ", ") + instrument.name;
  }
  bool lidar = name.empty() && !simulation.lidars.empty();
  for (const auto& one : simulation.lidars) {
    lidar = lidar || one.name == name;
    known += (known.empty() ? "" : ", ") + one.name;
  }
  if (picked.empty() && !lidar)
    throw base::Error(base::Fault::input,
                      simulation.file + ": no instrument is called '" + name + "'; there are: " + known);
  return picked;
}

plan::HeightRange seen_heights(const scene::CompiledScene& scene, const plan::ViewBounds& view) {
  if (!(scene.lo[2] <= scene.hi[2])) return {};
  return {scene.lo[2], std::min<double>(scene.hi[2], view.sensor_height_m)};
}

InstrumentJob prepare(const scene::Simulation& simulation, const scene::Instrument& instrument, Context& context,
                      const Planning& planning) {
  InstrumentJob job;
  auto planned = std::make_shared<scene::Instrument>(instrument);
  job.planned = planned;
  job.instrument = planned.get();
  const plan::ViewBounds view = sensors::view_bounds(instrument);
  auto start = std::chrono::steady_clock::now();
  job.table = air_table(air_request(simulation, instrument, view.sensor_height_m), context);
  job.table_s = seconds_since(start);
  const auto& scene = simulation.scene;
  job.notices = plan::one_direction_notices(job.table, instrument.name, view, seen_heights(scene, view));
  for (auto& notice : plan::channel_bands(instrument, job.table).notices) job.notices.push_back(std::move(notice));
  for (const auto& notice : job.notices) context.log.warning(instrument.name + ": " + notice);
  if (simulation.atmosphere.table_file.empty())  // of a table of the user's its maker has heard them
    for (auto& notice : air_notices(job.table)) job.notices.push_back(std::move(notice));
  start = std::chrono::steady_clock::now();
  job.plan = plan::make_plan(simulation, instrument, job.table, view);
  if (planning.replay) {
    const auto& entry = planner::find_entry(*planning.replay, instrument.name, false, planning.replay_path);
    job.decision = planner::replayed(entry, simulation, instrument, job.plan, planning.replay_path);
    planner::hold_tolerance(job.decision, simulation, instrument, job.plan, job.table, context.common.threads);
  } else if (planning.renderer) {
    job.decision = planner::decide(*planning.renderer, simulation, instrument, job.plan, job.table,
                                   planning.estimate_given, context.common.threads);
  } else {
    job.decision = planner::as_given(simulation, instrument, job.plan);
    planner::hold_tolerance(job.decision, simulation, instrument, job.plan, job.table, context.common.threads);
  }
  planner::add_small_objects(job.decision, simulation, instrument);
  planner::apply(job.decision, simulation, *planned, job.plan);
  for (const auto& notice : job.plan.notices) context.log.warning(notice);
  for (const auto& note : job.decision.notes) context.log.warning(note);
  job.plan_s = seconds_since(start);
  context.log.detail(instrument.name + ": atmosphere table in " + std::to_string(job.table_s) + " s, plan in " +
                     std::to_string(job.plan_s) + " s");
  context.log.debug(job.plan.report_json);
  return job;
}

render::RenderOptions render_options(const CommonOptions& common) {
  render::RenderOptions options;
  options.device = common.device;
  options.threads = common.threads;
  options.memory_bytes = common.memory_bytes;
  options.tuned = true;
  return options;
}

}  // namespace raycube::cli
