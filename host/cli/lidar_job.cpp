#include "host/cli/lidar_job.h"

#include <chrono>
#include <numbers>

#include "atmos_tables/compiler/lidar_profiles.h"
#include "host/base/error.h"
#include "host/lidar/air_column.h"
#include "host/lidar/make_lidar_plan.h"

namespace raycube::cli {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

LidarJob prepare_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Context& context) {
  LidarJob job;
  job.lidar = &lidar;
  auto start = std::chrono::steady_clock::now();
  const scene::AtmosphereSpec& air = simulation.atmosphere;
  std::unique_ptr<atmos::RenderTable> table;
  if (!air.none) {
    if (!air.layered)
      throw base::Error(base::Fault::input, simulation.file + ": LIDAR " + lidar.name +
                                                ": the atmosphere has no profiles of extinction and backscatter; use model = \"layered\", or \"none\" for no air");
    table = std::make_unique<atmos::RenderTable>(
        atmos::build_lidar(air, lidar::table_wavelengths(lidar::make_nodes(lidar)), atmos::lidar_heights(air)));
  }
  job.table_s = seconds_since(start);
  start = std::chrono::steady_clock::now();
  job.plan = lidar::make_lidar_plan(simulation, lidar, table.get());
  job.plan_s = seconds_since(start);
  context.log.detail(lidar.name + ": air profiles in " + std::to_string(job.table_s) + " s, plan in " + std::to_string(job.plan_s) + " s");
  return job;
}

std::vector<const scene::Lidar*> pick_lidars(const scene::Simulation& simulation, const std::string& name) {
  std::vector<const scene::Lidar*> picked;
  for (const auto& lidar : simulation.lidars)
    if (name.empty() || lidar.name == name) picked.push_back(&lidar);
  return picked;
}

}  // namespace raycube::cli
