#include "host/cli/dry_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/memory.h"
#include "host/render/tile_passes.h"
#include "host/render/truth.h"
#include "host/sensors/ray_groups.h"
#include "kernels/shared/structs.h"
#include "scene_compiler/scene_info.h"

namespace raycube::cli {

nlohmann::json dry_run_json(const scene::CompiledScene& scene, const InstrumentJob& job,
                            const render::RenderOptions& options, std::size_t tile_samples) {
  const auto& instrument = *job.instrument;
  const auto shape = render::make_stage_shape(instrument, job.plan, sensors::pixels_per_group(instrument));
  const std::size_t capacity = render::row_capacity_of(shape, options.row_capacity);
  const render::LeastMemory least = render::least_memory(scene, instrument, job.plan, capacity);
  render::require_memory(shape, least, instrument.pixels, capacity, options.memory_bytes);
  const auto size = render::choose_tile_size(shape, instrument.pixels, instrument.lines, capacity,
                                             options.memory_bytes / render::kBudgetShares, tile_samples,
                                             options.memory_bytes, 0, least);
  const std::uint64_t tile_pixels = std::uint64_t(size.lines) * size.columns;
  const std::uint64_t tile_bytes = tile_pixels * (shape.pixel_bytes() + shape.row_bytes(capacity));
  const std::uint64_t layers = render::truth_layer_names(scene, instrument).size();
  // A strip is being filled, one written, and two may wait.
  const std::uint64_t strip_bytes =
      4 * std::uint64_t(size.lines) * instrument.pixels * least.strip_values * sizeof(float);
  const std::uint64_t scene_bytes = scene::scene_info(scene).bytes;
  const std::uint64_t pixels = std::uint64_t(instrument.pixels) * instrument.lines;
  return {{"name", instrument.name},
          {"pixels", instrument.pixels},
          {"lines", instrument.lines},
          {"bands", instrument.bands.size()},
          {"samples_per_pixel", shape.samples},
          {"tile_lines", size.lines},
          {"tile_columns", size.columns},
          {"memory",
           {{"budget_bytes", options.memory_bytes},
            {"scene_bytes", scene_bytes},
            {"tile_bytes", tile_bytes},
            {"strip_bytes", strip_bytes},
            {"baked_rows_bytes_at_most", options.memory_bytes / render::kBudgetShares},
            {"total_bytes", scene_bytes + tile_bytes + strip_bytes}}},
          {"cube_bytes", pixels * instrument.bands.size() * (instrument.integer_scale ? 2 : sizeof(float))},
          {"truth_bytes", pixels * layers * sizeof(float)},
          {"plan", nlohmann::json::parse(job.plan.report_json)}};
}

double estimate_render_s(render::Renderer& renderer, const scene::Simulation& simulation, const InstrumentJob& job) {
  constexpr int kStretch = 256, kLines = 4;
  const auto& instrument = *job.instrument;
  const int columns = std::min(instrument.pixels, kStretch);
  const int first = (instrument.pixels - columns) / 2 / RC_GROUP_WIDTH * RC_GROUP_WIDTH;
  std::vector<render::Tile> tiles = {
      {instrument.lines / 2, 1, first, columns}};  // builds programs, bakes rows; not timed
  for (int k = 0; k < kLines; ++k)
    tiles.push_back({static_cast<int>((2 * k + 1) * std::int64_t(instrument.lines) / (2 * kLines)), 1, first, columns});
  std::optional<std::chrono::steady_clock::time_point> start;
  double seconds = 0;
  renderer.probe(instrument, job.plan, simulation.sun, simulation.seed, tiles, [&](const render::PixelProbe&) {
    const auto now = std::chrono::steady_clock::now();
    if (start)
      seconds = std::chrono::duration<double>(now - *start).count();
    else
      start = now;
  });
  return seconds / (kLines * columns) * instrument.pixels * instrument.lines;
}

namespace {

std::string adjacency_text(const nlohmann::json& plan) {
  const std::string mode = plan["mode"];
  if (mode == "off") return "off: no light between ground and air";
  if (mode == "mean") return "mean: every pixel gets the light of the scene's mean ground";
  return fmt::format("local: ground around each pixel from {} x {} nodes, {:.3g} m apart", plan["columns"].get<int>(),
                     plan["rows"].get<int>(), plan["step_m"].get<double>());
}

}  // namespace

std::string dry_run_text(const nlohmann::json& item) {
  const auto bytes = [](const nlohmann::json& value) { return base::format_bytes(value.get<std::uint64_t>()); };
  const auto number = [](const nlohmann::json& value) { return value.get<double>(); };
  const auto &plan = item["plan"], &memory = item["memory"];
  return fmt::format(
             "{}: {} x {} pixels, {} bands, {} samples per pixel\n"
             "  plan      nodes: {} heights, {} view angles, {} x {} path directions; sky: {} components, {} sets of "
             "{} directions; {} "
             "wavelengths\n"
             "  adjacency {}\n"
             "  error     {:.2g} estimated of {:.2g} that the plan may spend (tolerance {:.2g})\n"
             "  memory    scene {}, tile of {} x {} pixels {}, strips {}: {} of {}, baked rows at most {} more; the "
             "OpenCL driver's own "
             "comes on top\n"
             "  products  cube {}, truth {}\n",
             item["name"].get<std::string>(), item["pixels"].get<int>(), item["lines"].get<int>(),
             item["bands"].get<int>(), item["samples_per_pixel"].get<int>(), plan["height_m"]["count"].get<int>(),
             plan["sec_view_zenith"]["count"].get<int>(), plan["path_x"]["count"].get<int>(),
             plan["path_y"]["count"].get<int>(), plan["sky"]["components"].get<int>(), plan["sky"]["sets"].get<int>(),
             plan["sky"]["directions"].get<int>(), plan["spectral_grid"]["points"].get<int>(),
             adjacency_text(plan["adjacency"]), number(plan["error"]["total"]), number(plan["budget"]),
             number(plan["tolerance"]), bytes(memory["scene_bytes"]), item["tile_columns"].get<int>(),
             item["tile_lines"].get<int>(), bytes(memory["tile_bytes"]), bytes(memory["strip_bytes"]),
             bytes(memory["total_bytes"]), bytes(memory["budget_bytes"]), bytes(memory["baked_rows_bytes_at_most"]),
             bytes(item["cube_bytes"]), bytes(item["truth_bytes"])) +
         (item.contains("estimated_s")
              ? fmt::format(
                    "  time      about {:.1g} s to render, and the first time some seconds for the device's compiler\n",
                    number(item["estimated_s"]))
              : "");
}

}  // namespace raycube::cli
