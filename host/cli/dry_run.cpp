#include "host/cli/dry_run.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/memory.h"
#include "host/planner/seconds_text.h"

namespace raycube::cli {

nlohmann::json dry_run_json(const run::CameraJob& job, const run::CameraForecast& forecast,
                            std::optional<double> estimated_s) {
  const auto& instrument = job.image();
  nlohmann::json item = {{"name", instrument.name},
                         {"pixels", instrument.pixels},
                         {"lines", instrument.lines},
                         {"bands", instrument.bands.size()},
                         {"samples_per_pixel", forecast.samples},
                         {"tile_lines", forecast.tile_lines},
                         {"tile_columns", forecast.tile_columns},
                         {"memory",
                          {{"budget_bytes", forecast.budget_bytes},
                           {"scene_bytes", forecast.scene_bytes},
                           {"tile_bytes", forecast.tile_bytes},
                           {"strip_bytes", forecast.strip_bytes},
                           {"baked_rows_bytes_at_most", forecast.baked_rows_bytes},
                           {"total_bytes", forecast.total_bytes()}}},
                         {"cube_bytes", forecast.cube_bytes},
                         {"truth_bytes", forecast.truth_bytes},
                         {"plan", run::plan_json(job)}};
  if (estimated_s) item["estimated_s"] = *estimated_s;
  return item;
}

nlohmann::json dry_run_json(const scene::Lidar& lidar, const run::LidarForecast& forecast) {
  const auto& plan = forecast.job.plan;
  return {{"name", lidar.name},
          {"kind", "lidar"},
          {"pulses", lidar.pulses},
          {"bins", lidar.gate.bins},
          {"pixels", plan.pixels()},
          {"lines", plan.lines()},
          {"rays", forecast.rays},
          {"spectral_nodes", plan.nodes.size()},
          {"plan", run::plan_json(forecast.job)},
          {"pulses_per_batch", forecast.pulses_per_batch},
          {"waveform_bytes", forecast.waveform_bytes}};
}

namespace {

std::string adjacency_text(const plan::Plan& plan) {
  const plan::EnvironmentMap& map = plan.environment;
  if (map.empty()) return "off: no light between ground and air";
  if (!map.local) return "mean: every pixel gets the light of the scene's mean ground";
  return fmt::format("local: ground around each pixel from {} x {} nodes, {:.3g} m apart", map.columns, map.rows,
                     map.step_m);
}

}  // namespace

std::string dry_run_text(const run::CameraJob& job, const run::CameraForecast& forecast,
                         std::optional<double> estimated_s) {
  const auto& instrument = job.image();
  const plan::Plan& plan = job.plan;
  return fmt::format(
             "{}: {} x {} pixels, {} bands, {} samples per pixel\n"
             "  plan      nodes: {} heights, {} view angles, {} x {} path directions; sky: {} components, {} "
             "directions; {} wavelengths\n"
             "  adjacency {}\n"
             "  error     {:.2g} estimated of {:.2g} that the plan may spend (tolerance {:.2g})\n"
             "  memory    scene {}, tile of {} x {} pixels {}, strips {}: {} of {}, baked rows at most {} more; the "
             "OpenCL driver's own "
             "comes on top\n"
             "  products  cube {}, truth {}\n",
             instrument.name, instrument.pixels, instrument.lines, instrument.bands.size(), forecast.samples,
             plan.height.count, plan.view.count, plan.path_x.count, plan.path_y.count, plan.sky_components,
             plan.sky.rays, plan.wavelength_um.size(), adjacency_text(plan), plan.report.total_error,
             plan.report.budget, plan.tolerance, base::format_bytes(forecast.scene_bytes), forecast.tile_columns,
             forecast.tile_lines, base::format_bytes(forecast.tile_bytes), base::format_bytes(forecast.strip_bytes),
             base::format_bytes(forecast.total_bytes()), base::format_bytes(forecast.budget_bytes),
             base::format_bytes(forecast.baked_rows_bytes), base::format_bytes(forecast.cube_bytes),
             base::format_bytes(forecast.truth_bytes)) +
         (estimated_s
              ? fmt::format(
                    "  time      about {} s to render, and the first time some seconds for the device's compiler\n",
                    planner::seconds_text(*estimated_s))
              : "");
}

std::string dry_run_text(const scene::Lidar& lidar, const run::LidarForecast& forecast) {
  const auto& plan = forecast.job.plan;
  return fmt::format(
      "{}: {} pulses, {} pixels x {} wavelengths x {} bins\n"
      "  rays      {:.3g} first rays, {} spectral nodes\n"
      "  memory    {} pulses at a time\n"
      "  products  waveforms {}\n",
      lidar.name, lidar.pulses, plan.pixels(), plan.lines(), lidar.gate.bins, static_cast<double>(forecast.rays),
      plan.nodes.size(), forecast.pulses_per_batch, base::format_bytes(forecast.waveform_bytes));
}

}  // namespace raycube::cli
