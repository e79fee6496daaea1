#include "host/run/camera_job.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <tuple>

#include "host/base/parallel.h"
#include "host/base/timing.h"
#include "host/run/air_table.h"
#include "host/plan/baked_rows.h"
#include "host/plan/band_truth.h"
#include "host/plan/channel_bands.h"
#include "host/plan/one_direction.h"
#include "host/planner/bounce_choice.h"
#include "host/planner/open_share.h"
#include "host/planner/plan_file.h"
#include "host/planner/plan_lines.h"
#include "host/sensors/view_bounds.h"

namespace raycube::run {

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

plan::HeightRange seen_heights(const scene::CompiledScene& scene, const plan::ViewBounds& view) {
  if (!(scene.lo[2] <= scene.hi[2])) return {};
  return {scene.lo[2], std::min<double>(scene.hi[2], view.sensor_height_m)};
}

CameraJob prepare_camera(const scene::Simulation& simulation, const scene::Instrument& given, Services& services,
                         const Planning& planning) {
  CameraJob job;
  job.cells = sensors::make_cells(given, services.threads);
  const scene::Instrument& instrument = job.cells ? job.cells->rendered : given;
  auto planned = std::make_shared<scene::Instrument>(instrument);
  job.planned = planned;
  job.instrument = planned.get();
  const plan::ViewBounds view = sensors::view_bounds(instrument);
  auto start = std::chrono::steady_clock::now();
  job.table = air_table(air_request(simulation, instrument, view.sensor_height_m), services);
  job.table_s = base::seconds_since(start);
  const auto& scene = simulation.scene;
  job.notices = plan::one_direction_notices(job.table, instrument.name, view, seen_heights(scene, view));
  if (auto notice = coarse_sun_notice(simulation.atmosphere, instrument.bands))
    job.notices.push_back(std::move(*notice));
  for (auto& notice : plan::channel_bands(instrument, job.table).notices) job.notices.push_back(std::move(notice));
  for (const auto& notice : job.notices) services.log.warning(instrument.name + ": " + notice);
  if (simulation.atmosphere.table_file.empty())  // of a table of the user's its maker has heard them
    for (auto& notice : air_notices(job.table)) job.notices.push_back(std::move(notice));
  start = std::chrono::steady_clock::now();
  const double processor_before_s = base::processor_seconds();
  double kernels_processor_s = 0;
  services.log.set_status(instrument.name + ": planning nodes and components");
  // Which of the scene's objects are small needs nothing of the plan.
  auto small = base::beside(services.threads, [&] {
    return planning.renderer ? sensors::SmallObjectPixels(planning.renderer->objects(), instrument)
                             : sensors::SmallObjectPixels(simulation.scene, instrument);
  });
  job.plan = plan::make_plan(simulation, instrument, job.table, view, services.threads);
  // Before the programs are compiled: a plan that no tolerance holds needs none.
  planner::Decision held = planner::as_given(simulation, instrument, job.plan);
  planner::hold_tolerance(held, simulation, instrument, job.plan, job.table, services.threads);
  services.log.set_status(instrument.name + ": planning samples and sky directions");
  job.plan.baked = std::make_shared<plan::BakedRows>();
  const auto load_programs = [&](const scene::Instrument& launched, const plan::Plan& plan) {
    const auto loading = std::chrono::steady_clock::now();
    const double processor_s = base::processor_seconds();
    planning.renderer->load_programs(launched, plan);
    job.kernels_s += base::seconds_since(loading), kernels_processor_s += base::processor_seconds() - processor_s;
  };
  const auto load_first = [&] { load_programs(planner::first_launched(simulation, instrument, job.plan), job.plan); };
  if (planning.renderer && (job.plan.sends_rays() || !planning.replay)) load_first();  // else the render loads its own
  if (planning.renderer) planner::measure_open_share(*planning.renderer, simulation, instrument, job.plan);
  if (planning.renderer && planner::choose_bounces(*planning.renderer, simulation, instrument, job.plan)) load_first();
  if (planning.replay) {
    const auto& entry = planner::find_entry(*planning.replay, instrument.name, false, planning.replay_path);
    job.decision = planner::replayed(entry, planner::changes_since(*planning.replay, simulation), simulation,
                                     instrument, job.plan, planning.replay_path);
    planner::take_held(job.decision, held);
  } else if (planning.renderer) {
    job.decision = planner::decide(*planning.renderer, simulation, instrument, job.plan, job.table,
                                   planning.estimate_given, services.threads, services.progress, &held);
  } else {
    job.decision = std::move(held);
  }
  planner::add_small_objects(job.decision, instrument, small.get());
  planner::apply(job.decision, *planned, job.plan);
  if (instrument.first_opaque || !plan::truth_columns(job.plan, instrument).empty()) {
    job.decision.image.reset();  // it has no such truth
    if (planning.renderer) load_programs(*planned, *render_plan(job));
  }
  services.log.set_status("");
  for (const auto& notice : job.plan.notices) services.log.warning(notice);
  for (const auto& note : job.decision.notes) services.log.warning(note);
  job.plan_s = base::seconds_since(start) - job.kernels_s;
  job.plan_processor_s = base::processor_seconds() - processor_before_s - kernels_processor_s;
  if (job.decision.image)  // which is the render's
    job.plan_s -= job.decision.image->render_s, job.plan_processor_s -= job.decision.image->processor_s;
  services.log.detail(instrument.name + ": atmosphere table in " + std::to_string(job.table_s) + " s, plan in " +
                      std::to_string(job.plan_s) + " s");
  services.log.debug(plan_json(job).dump(2));
  return job;
}

std::shared_ptr<const plan::Plan> render_plan(const CameraJob& job) {
  const auto cubes = plan::truth_columns(job.plan, *job.instrument);
  if (cubes.empty()) return {std::shared_ptr<void>(), &job.plan};
  return std::make_shared<plan::Plan>(plan::with_truth(job.plan, cubes));
}

nlohmann::json plan_json(const CameraJob& job) {
  nlohmann::json out = plan::plan_json(job.plan);
  out["planner"] = planner::decision_json(job.decision, planner::plan_lines(job.decision, job.plan));
  return out;
}

}  // namespace raycube::run
