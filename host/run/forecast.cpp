#include "host/run/forecast.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include "host/planner/cost_model.h"
#include "host/render/tile_passes.h"
#include "host/render/truth.h"
#include "host/sensors/ray_groups.h"
#include "kernels/shared/structs.h"
#include "scene_compiler/scene_info.h"

namespace raycube::run {

CameraForecast forecast_camera(const scene::CompiledScene& scene, const CameraJob& job,
                               const render::RenderOptions& options, std::size_t tile_samples) {
  const auto& instrument = *job.instrument;
  const auto plan = render_plan(job);
  const auto shape = render::make_stage_shape(instrument, *plan, sensors::pixels_per_group(instrument));
  const std::size_t capacity = render::row_capacity_of(shape, options.row_capacity);
  const render::LeastMemory least = render::least_memory(scene, instrument, *plan, capacity);
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
  const auto& image = job.image();
  const std::uint64_t pixels = std::uint64_t(image.pixels) * image.lines;
  CameraForecast forecast;
  forecast.samples = shape.samples;
  forecast.tile_lines = size.lines, forecast.tile_columns = size.columns;
  forecast.budget_bytes = options.memory_bytes;
  forecast.scene_bytes = scene_bytes, forecast.tile_bytes = tile_bytes, forecast.strip_bytes = strip_bytes;
  forecast.baked_rows_bytes = options.memory_bytes / render::kBudgetShares;
  forecast.cube_bytes = pixels * image.bands.size() * (image.integer_scale ? 2 : sizeof(float));
  forecast.truth_bytes = pixels * layers * sizeof(float);
  const std::size_t cubes = plan->truth.size() + (instrument.asks_for(scene::BandTruth::transmission) ? 1 : 0);
  forecast.truth_bytes += pixels * cubes * image.bands.size() * sizeof(float);
  return forecast;
}

namespace {

/// Of pixels that are rendered anew for small objects.
double small_objects_s(const CameraJob& job) {
  const planner::Decision& d = job.decision;
  if (!d.small.on) return 0;
  double seconds = 0;
  for (const auto& [samples, pixels] : d.small.levels)
    seconds += planner::CostModel().whole_image_s(
        planner::pixel_counts(job.plan, samples, d.sampling.directions, d.sampling.paths_per_two),
        static_cast<double>(pixels));
  return seconds;
}

}  // namespace

double nominal_render_s(const CameraJob& job) {
  const double pixels = static_cast<double>(job.instrument->pixels) * job.instrument->lines;
  return planner::CostModel().whole_image_s(job.decision.counts, pixels) + small_objects_s(job);
}

double estimate_render_s(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job) {
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
  renderer.probe(instrument, *render_plan(job), simulation.sun, simulation.seed, tiles, [&](const render::PixelProbe&) {
    const auto now = std::chrono::steady_clock::now();
    if (start)
      seconds = std::chrono::duration<double>(now - *start).count();
    else
      start = now;
  });
  // The stretches hardly meet small objects, whose pixels take a thousand times as long.
  return seconds / (kLines * columns) * instrument.pixels * instrument.lines + small_objects_s(job);
}

}  // namespace raycube::run
