#include "host/render/tile_shape.h"

#include <algorithm>
#include <string>

#include "host/base/error.h"
#include "kernels/shared/rows.h"
#include "kernels/shared/structs.h"

namespace raycube::render {

std::size_t StageShape::row_bytes(std::size_t capacity) const {
  const std::size_t floats = static_cast<std::size_t>(accumulators()) * (chunked() ? 2 : 1);
  return sizeof(std::uint32_t) + capacity * (sizeof(std::uint64_t) + floats * sizeof(float)) +  // row
         (environment ? 4 * (sizeof(std::uint32_t) + sizeof(float)) : 0) + sizeof(std::uint32_t) +
         term_capacity(capacity) * (sizeof(std::uint32_t) + sizeof(float));
}

std::size_t StageShape::pixel_bytes() const {
  const std::size_t padded = static_cast<std::size_t>(padded_samples);
  const std::size_t sums = (static_cast<std::size_t>(heights) + RC_TRUTH_SUMS) * (chunked() ? 2 : 1) * sizeof(float);
  return padded * (2 + 6 + 1 + 4 * static_cast<std::size_t>(sky_quads())) * sizeof(float) + padded / 8 + sums +
         sizeof(shared::RayGroup) + static_cast<std::size_t>(bands_padded) * sizeof(float);
}

StageShape make_stage_shape(const scene::Instrument& instrument, const plan::Plan& plan, int pixels_per_group) {
  StageShape shape;
  shape.samples = instrument.samples_u * instrument.samples_v;
  if (shape.samples <= kMaxChunkSamples) {
    shape.chunk_samples = shape.samples;
  } else if (instrument.sampler == scene::SamplerKind::lattice) {
    shape.chunk_samples = kMaxChunkSamples;
  } else {
    if (instrument.samples_u > kMaxChunkSamples)
      throw base::Error(base::Fault::input, "instrument '" + instrument.name + "': a sample grid is at most " +
                                                std::to_string(kMaxChunkSamples) + " samples wide (found " +
                                                std::to_string(instrument.samples_u) +
                                                "); make it taller instead, or use samples = { lattice = N }");
    shape.chunk_samples = kMaxChunkSamples / instrument.samples_u * instrument.samples_u;
  }
  shape.chunks = (shape.samples + shape.chunk_samples - 1) / shape.chunk_samples;
  shape.padded_samples = (shape.chunk_samples + 15) / 16 * 16;
  shape.pixels_per_group = pixels_per_group;
  shape.sun = plan.sun_sources;
  shape.components = plan.components();
  shape.sky_share = plan.sky.share;
  shape.thermal_components = plan.thermal.components();
  shape.temperatures = plan.thermal.nodes();
  shape.heights = plan.height.count;
  shape.views = plan.view.count;
  shape.path_x = plan.path_x.count;
  shape.path_y = plan.path_y.count;
  shape.channels = std::max({plan.source_channels(), plan.path_channels(), plan.environment_channels()});
  shape.environment = !plan.environment.empty();
  shape.bands = static_cast<int>(plan.bands.size());
  shape.bands_padded = (shape.bands + 15) / 16 * 16;
  return shape;
}

namespace {

/// Bytes that a pixel adds to the largest single buffer, which must stay inside one allocation.
std::size_t largest_buffer(const StageShape& shape, std::size_t capacity) {
  return std::max({static_cast<std::size_t>(shape.padded_samples) * 6 * sizeof(float),
                   static_cast<std::size_t>(shape.bands_padded) * sizeof(float), shape.row_bytes(capacity)});
}

}  // namespace

void require_memory(const StageShape& shape, const LeastMemory& least, int pixels, std::size_t capacity,
                    std::size_t memory_bytes) {
  const std::size_t strip_pixel = kStripsAtOnce * least.strip_values * sizeof(float);
  const std::size_t device_pixel = shape.pixel_bytes() + shape.row_bytes(capacity) + least.more_bytes;
  const std::size_t group = RC_GROUP_WIDTH * std::max({device_pixel, strip_pixel, largest_buffer(shape, capacity)});
  const std::size_t strips = strip_pixel * static_cast<std::size_t>(pixels);
  const std::size_t rows = least.table_rows * static_cast<std::size_t>(shape.channels) *
                               static_cast<std::size_t>(shape.bands_padded) * sizeof(float) +
                           least.fine_bytes;
  const std::size_t need = kBudgetShares * std::max({group, strips, rows});
  if (need <= memory_bytes) return;
  const char* const what = strips >= group && strips >= rows ? "the strips of one line on their way out"
                           : rows >= group && least.fine_bytes > 0
                               ? "the band-table rows of one pixel and the samples of small objects "
                                 "(small_objects = \"off\" spares these)"
                           : rows >= group ? "the band-table rows of one pixel"
                                           : "one group of pixels";
  throw base::Error(
      base::Fault::input,
      std::string("--memory is too small for ") + what + ": need " + std::to_string(need) + " bytes, found " +
          std::to_string(memory_bytes) +
          "; raise --memory, or lower the samples per pixel, the number of bands or the pixels of a line");
}

TileSize choose_tile_size(const StageShape& shape, int pixels, int lines, std::size_t capacity,
                          std::size_t budget_bytes, std::size_t tile_samples, std::size_t max_alloc_bytes,
                          int forced_lines, const LeastMemory& least) {
  const std::size_t per_pixel = shape.pixel_bytes() + shape.row_bytes(capacity) + least.more_bytes;
  const std::size_t largest = largest_buffer(shape, capacity);
  constexpr std::size_t kFewestSamples =
      32;  // an image of a few samples a pixel fills its memory with bands, not with samples
  const std::size_t useful = tile_samples / std::max(kFewestSamples, static_cast<std::size_t>(shape.padded_samples));
  const std::size_t strips = kStripsAtOnce * least.strip_values * sizeof(float);
  const std::size_t fit = std::min({budget_bytes / std::max(per_pixel, strips), max_alloc_bytes / largest,
                                    std::max(useful, static_cast<std::size_t>(pixels))});
  const std::size_t width = static_cast<std::size_t>(pixels);
  if (forced_lines > 0) return {std::min(forced_lines, lines), pixels};
  if (fit >= width)
    return {static_cast<int>(std::min<std::size_t>(fit / width, static_cast<std::size_t>(lines))), pixels};
  const std::size_t columns = fit / RC_GROUP_WIDTH * RC_GROUP_WIDTH;
  if (columns == 0)
    throw base::Error(base::Fault::input,
                      "--memory is too small for one group of pixels: need " +
                          std::to_string(kBudgetShares * std::max(per_pixel, largest) * RC_GROUP_WIDTH) +
                          " bytes, found " + std::to_string(kBudgetShares * budget_bytes) +
                          "; raise --memory, or lower the samples per pixel or the number of bands");
  return {1, static_cast<int>(columns)};
}

}  // namespace raycube::render
