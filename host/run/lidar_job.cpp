#include "host/run/lidar_job.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atmos_tables/compiler/lidar_profiles.h"
#include "host/base/error.h"
#include "host/base/timing.h"
#include "host/run/air_table.h"
#include "host/lidar/air_column.h"
#include "host/lidar/make_lidar_plan.h"
#include "host/planner/plan_file.h"
#include "host/run/other_pulses.h"

namespace raycube::run {

std::unique_ptr<atmos::RenderTable> lidar_air(const scene::Simulation& simulation, const scene::Lidar& lidar) {
  const scene::AtmosphereSpec& air = simulation.atmosphere;
  if (!air.table_file.empty())
    throw base::Error(
        base::Fault::input,
        fmt::format("{}: LIDAR {}: an atmosphere table has no profiles of extinction and backscatter (found tables = "
                    "\"{}\"); give the LIDAR a file of its own with model = \"layered\", or \"none\" for no air",
                    simulation.file, lidar.name, air.table_file));
  if (air.none) return {};
  if (air.layered)
    return std::make_unique<atmos::RenderTable>(
        atmos::build_lidar(air, lidar::table_wavelengths(lidar::make_nodes(lidar)), atmos::lidar_heights(air)));
  throw base::Error(base::Fault::input, simulation.file + ": LIDAR " + lidar.name +
                                            ": the atmosphere has no profiles of extinction and backscatter; use model "
                                            "= \"layered\", or \"none\" for no air");
}

namespace {

/// A run is not lost because its error cannot be told.
void find_error(render::LidarRenderer& renderer, const lidar::LidarPlan& seen, LidarJob& job) {
  try {
    job.error = planner::own_error(renderer, seen, job.decision);
  } catch (const base::Error& failure) {
    if (failure.fault() == base::Fault::interrupted) throw;
    job.error.from = failure.what();
  } catch (const std::bad_alloc&) {
    job.error.from = "there is not enough memory for a trial";
  }
}

}  // namespace

LidarJob prepare_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Services& services,
                       const LidarPlanning& planning) {
  LidarJob job;
  job.lidar = &lidar;
  auto start = std::chrono::steady_clock::now();
  const std::unique_ptr<atmos::RenderTable> table = lidar_air(simulation, lidar);
  if (table) {
    job.air_json = table->provenance_json;
    job.air_notices = air_notices(*table);
    say_air(*table, services);
  }
  job.table_s = base::seconds_since(start);
  start = std::chrono::steady_clock::now();
  job.plan = lidar::make_lidar_plan(simulation, lidar, table.get());
  // Light that is folded into the gate is tried where it comes from.
  lidar::LidarPlan seen =
      planning.renderer ? OtherPulses(simulation, job.plan).brightest(job.plan, *planning.renderer) : job.plan;
  if (planning.replay) {
    const auto& entry = planner::find_entry(*planning.replay, lidar.name, true, planning.replay_path);
    job.decision = planner::replayed(entry, planner::changes_since(*planning.replay, simulation), job.plan,
                                     simulation.tolerance, planning.replay_path);
  } else if (planning.renderer) {
    job.decision = planner::decide_subrays(*planning.renderer, seen, simulation.tolerance, planning.estimate_given);
  } else {
    job.decision = planner::subrays_as_given(job.plan, simulation.tolerance);
  }
  for (lidar::LidarPlan* plan : {&job.plan, &seen})
    if (job.decision.subrays != plan->lidar.transport.subrays) planner::set_subrays(*plan, job.decision.subrays);
  for (const auto& note : job.decision.notes) services.log.warning(note);
  job.error.tolerance = job.decision.tolerance;
  if (planning.renderer && (job.decision.estimated || planning.own_error)) find_error(*planning.renderer, seen, job);
  job.plan.waveform_error = job.decision.pulse_error >= 0 ? job.decision.pulse_error
                            : job.error.known()           ? job.error.total
                                                          : 0;
  job.plan_s = base::seconds_since(start);
  services.log.detail(lidar.name + ": air profiles in " + std::to_string(job.table_s) + " s, plan in " +
                      std::to_string(job.plan_s) + " s");
  return job;
}

nlohmann::json plan_json(const LidarJob& job) {
  return planner::lidar_decision_json(job.decision, planner::lidar_lines(job.decision, job.plan));
}

}  // namespace raycube::run
