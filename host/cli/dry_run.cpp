#include "host/cli/dry_run.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/memory.h"
#include "host/base/text.h"
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
             "{}: {} x {} pixels, {}, {} per pixel\n"
             "  plan      nodes: {}, {}, {} x {} path directions; sky: {}, {}; {}\n"
             "  adjacency {}\n"
             "  error     {:.2g} estimated of {:.2g} that the plan may spend (tolerance {:.2g})\n"
             "  memory    scene {}, tile of {} x {} pixels {}, strips {}: {} of {}, baked rows at most {} more; the "
             "OpenCL driver's own "
             "comes on top\n"
             "  products  cube {}, truth {}\n",
             instrument.name, instrument.pixels, instrument.lines, base::counted(instrument.bands.size(), "band"),
             base::counted(static_cast<std::size_t>(forecast.samples), "sample"),
             base::counted(static_cast<std::size_t>(plan.height.count), "height"),
             base::counted(static_cast<std::size_t>(plan.view.count), "view angle"), plan.path_x.count,
             plan.path_y.count, base::counted(static_cast<std::size_t>(plan.sky_components), "component"),
             base::counted(static_cast<std::size_t>(plan.sky.rays), "direction"),
             base::counted(plan.wavelength_um.size(), "wavelength"), adjacency_text(plan), plan.report.total_error,
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
      "{}: {}, {} pixels x {} wavelengths x {} bins\n"
      "  rays      {} first rays, {}\n"
      "  memory    {} at a time\n"
      "  products  waveforms {}\n",
      lidar.name, base::counted(static_cast<std::size_t>(lidar.pulses), "pulse"), plan.pixels(), plan.lines(),
      lidar.gate.bins, base::about_count(static_cast<double>(forecast.rays)),
      base::counted(plan.nodes.size(), "spectral node"),
      base::counted(static_cast<std::size_t>(forecast.pulses_per_batch), "pulse"),
      base::format_bytes(forecast.waveform_bytes));
}

}  // namespace raycube::cli
