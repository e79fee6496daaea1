#include "host/plan/plan_report.h"

#include <nlohmann/json.hpp>

#include "host/plan/plan.h"

namespace raycube::plan {

namespace {

using Json = nlohmann::json;

Json to_json(const std::vector<SkyLevelReport>& levels) {
  Json out = Json::array();
  for (const auto& level : levels)
    out.push_back({{"components", level.components},
                   {"error", level.error},
                   {"worst_obstacle_error_of_sky_irradiance", level.obstacle_error},
                   {"refused_negative", level.negative}});
  return out;
}

Json to_json(const AxisErrors& errors) {
  return {{"counts", errors.counts},           {"source_height", errors.source_height},
          {"source_view", errors.source_view}, {"path_height", errors.path_height},
          {"path_x", errors.path_x},           {"path_y", errors.path_y}};
}

Json to_json(const NodeAxis& axis) { return {{"first", axis.first}, {"step", axis.step}, {"count", axis.count}}; }

Json ground_json(const Plan& plan) {
  const EnvironmentMap& map = plan.environment;
  if (map.empty()) return {{"mode", ground_mode(plan)}};
  Json mean = Json::object();
  for (const auto& [material, share] : plan.report.mean_ground) mean[material] = share;
  return {{"mode", ground_mode(plan)}, {"columns", map.columns},          {"rows", map.rows}, {"step_m", map.step_m},
          {"raster_m", map.raster_m},  {"sensor_height_m", map.height_m}, {"mean", mean}};
}

Json sky_json(const Plan& plan) {
  Json out = {{"components", plan.sky_components},
              {"levels", to_json(plan.report.sky_levels)},
              {"directions", plan.sky.rays},
              {"paths", plan.paths()},
              {"cosine_share", plan.sky.cosine_share},
              {"sun_share", plan.sky.sun_share},
              {"asymmetry", plan.sky.asymmetry},
              {"irradiance_map_size", plan.irradiance.size},
              {"irradiance_map_error", plan.report.irradiance_map_error}};
  if (const auto& difference = plan.report.diffuse_irradiance_row_difference)
    out["diffuse_irradiance_row_difference"] = *difference;
  return out;
}

Json thermal_json(const Plan& plan, const ThermalReport& thermal) {
  return {{"sky_components", plan.thermal.sky_components},
          {"sky_levels", to_json(thermal.sky_levels)},
          {"temperature_nodes_K", plan.thermal.temperature_K},
          {"temperatures", thermal.temperatures},
          {"surroundings_K", plan.thermal.surroundings_K},
          {"sun_share", thermal.sun_share},
          {"sky_share", thermal.sky_share},
          {"sun_left_out", plan.sun_sources == 0},
          {"sky_left_out", thermal.sky_left_out}};
}

}  // namespace

std::string ground_mode(const Plan& plan) {
  return plan.environment.empty() ? "off" : plan.environment.local ? "local" : "mean";
}

std::vector<std::pair<std::string, int>> given_overrides(const scene::PlanOverrides& given) {
  std::vector<std::pair<std::string, int>> out;
  for (const auto& [key, value] : {std::pair{"height_nodes", given.height_nodes},
                                   {"path_nodes", given.path_nodes},
                                   {"sky_rank", given.sky_rank},
                                   {"view_nodes", given.view_nodes}})
    if (value > 0) out.emplace_back(key, value);
  return out;
}

nlohmann::json plan_json(const Plan& plan) {
  const PlanReport& report = plan.report;
  Json out = {
      {"tolerance", plan.tolerance},
      {"budget", report.budget},
      {"spectral_grid",
       {{"points", plan.wavelength_um.size()}, {"table_nodes", report.table_nodes}, {"bands", plan.bands.size()}}},
      {"height_m", to_json(plan.height)},
      {"sec_view_zenith", to_json(plan.view)},
      {"path_x", to_json(plan.path_x)},
      {"path_y", to_json(plan.path_y)},
      {"source_channels", plan.source_channels()},
      {"path_channels", plan.path_channels()},
      {"error",
       {{"source_nodes", report.source_error},
        {"path_nodes", report.path_error},
        {"sky_components", report.sky_error},
        {"total", report.total_error}}},
      {"sky", sky_json(plan)},
      {"adjacency", ground_json(plan)},
      {"node_errors", to_json(report.axes)}};
  if (const Bounces& b = plan.bounces; b.levels > 0) {
    Json skeleton = Json::array();
    for (const std::size_t i : b.skeleton) skeleton.push_back(plan.wavelength_um[i]);
    out["bounces"] = {{"levels", b.levels},
                      {"skeleton_um", skeleton},
                      {"skeleton_error", b.error},
                      {"skeleton_error_of", b.material_error},
                      {"amplified", b.amplified}};
  }
  if (report.bounces.chosen)
    out["bounces"]["levels"] = plan.bounces.levels, out["bounces"]["missed"] = report.bounces.missed,
    out["bounces"]["missed_by_light_scattered_once"] = report.bounces.once_missed;
  if (report.given.any()) {
    Json given = Json::object();
    for (const auto& [key, value] : given_overrides(report.given)) given[key] = value;
    out["given"] = given, out["within_tolerance"] = report.within_tolerance;
  }
  if (report.thermal) {
    out["error"]["temperature_nodes"] = report.thermal->temperature_nodes_error;
    out["error"]["left_out"] = report.thermal->left_out_error;
    out["thermal"] = thermal_json(plan, *report.thermal);
  }
  if (const auto& dark = report.thermal_left_out)
    out["thermal_left_out"] = {{"share", dark->share}, {"band", dark->band}, {"from", dark->from}};
  return out;
}

}  // namespace raycube::plan
