#include "host/render/tile_shape.h"

#include <algorithm>
#include <string>

#include "host/base/error.h"
#include "host/cl/program.h"
#include "host/render/scene_buffers.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::render {

std::size_t StageShape::row_bytes(std::size_t capacity) const {
  constexpr std::size_t kTerm = sizeof(std::uint32_t) + sizeof(float);  // a row of the band table and its weight
  return rows(capacity).row_bytes() + (environment ? RC_ENVIRONMENT_NODES * kTerm : 0) + sizeof(std::uint32_t) +
         term_capacity(capacity) * kTerm;
}

std::size_t StageShape::pixel_bytes() const {
  return tile().bytes() + rows(0).pixel_bytes() + sizeof(shared::RayGroup) +
         static_cast<std::size_t>(bands_padded) * sizeof(float) +
         (first_opaque ? tile().near * sizeof(std::uint32_t) : 0) + path_steps * sizeof(shared::PathStep);
}

StageShape make_stage_shape(const scene::Instrument& instrument, const plan::Plan& plan, int pixels_per_group) {
  StageShape shape;
  shape.samples_u = instrument.samples_u, shape.samples_v = instrument.samples_v;
  shape.samples = shape.samples_u * shape.samples_v;
  shape.sampler = instrument.sampler;
  shape.support_px = static_cast<float>(instrument.psf_support_px);
  shape.moving = sensors::pose_moves(instrument);
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
  shape.pixels_per_group = pixels_per_group;
  shape.sun = plan.sun_sources;
  shape.components = plan.components();
  shape.lamps = plan.lamps.sources();
  shape.matter = plan.matter;
  shape.lambertian = !plan.matter.shaped && plan.matter.further_records > 0;
  if (shape.lambertian) shape.matter.shaped = true;
  shape.thermal_components = plan.thermal.components();
  shape.temperatures = plan.thermal.nodes();
  shape.lobe_albedo = plan.matter.shaped && !plan.thermal.albedo_at.empty();
  shape.heights = plan.height.count;
  shape.views = plan.view.count;
  shape.path_x = plan.path_x.count;
  shape.path_y = plan.path_y.count;
  shape.covers = !plan.truth.empty();
  shape.channels =
      std::max({plan.source_channels() + (shape.covers ? 1 : 0), plan.path_channels(), plan.environment_channels()});
  shape.environment = !plan.environment.empty();
  shape.first_opaque = instrument.first_opaque && (plan.matter.through || plan.matter.plates);
  shape.bounces = plan.bounces.any(), shape.skeleton = static_cast<int>(plan.bounces.skeleton.size());
  if (plan.bounces.logged)
    shape.path_steps =
        static_cast<std::size_t>(RC_NUMBERED_PATHS(plan.paths())) * static_cast<std::size_t>(plan.bounces.levels + 1);
  shape.bands = static_cast<int>(plan.columns());
  shape.bands_padded = RC_PADDED(shape.bands);
  return shape;
}

shared::TileShape StageShape::arguments() const {
  const auto count = [](auto value) { return static_cast<std::uint32_t>(value); };
  const shared::TileElements elements = tile();
  return {.near = count(elements.near),
          .words = count(elements.words),
          .own_sides = count(matter.sides() - matter.further),
          .through = count(matter.through),
          .further = count(matter.further),
          .pixels_per_group = count(pixels_per_group),
          .most_visits = moving ? 0 : RC_NONE,
          .sky_planes = count(sky_planes()),
          .sun = count(sun),
          .components = count(components),
          .thermal_components = count(thermal_components),
          .lamps = count(lamps),
          .temperatures = count(temperatures),
          .heights = count(heights),
          .views = count(views),
          .path_x = count(path_x),
          .path_y = count(path_y),
          .channels = count(channels),
          .materials = matter.materials,
          .chunked = count(chunked()),
          .covers = count(covers),
          .skeleton = count(skeleton_padded()),
          .lobe_albedo = count(lobe_albedo),
          .plates = count(matter.plates)};
}

std::string matter_options(const scene::CameraMatter& matter) {
  std::string out;
  if (matter.shaped)
    out = cl::define("RC_SHAPED", 1) + cl::define("RC_THROUGH", 1) + cl::define("RC_PLATES", 1) +
          cl::define("RC_GLOSSY", 1);
  else if (matter.through)
    out = cl::define("RC_THROUGH", 1);
  if (matter.further_records > 0) out += cl::define("RC_FURTHER_RECORDS", matter.further_records);
  if (matter.shaped && matter.further_records > 0) out += cl::define("RC_FURTHER", matter.further_records);
  return out;
}

namespace {

/// Wavelengths that paths have room for.
int path_room(int wavelengths, bool on_cpu) {
  constexpr int kMost = 128;  // that a plan has
  return on_cpu ? std::max(wavelengths, kMost) : wavelengths;
}

}  // namespace

ProgramOptions program_options(const StageShape& shape, std::uint32_t stack_bound, bool on_cpu) {
  std::string all = "-cl-std=CL1.2";
  if (!on_cpu)
    all += cl::define("RC_CHUNK_SAMPLES", RC_PADDED(shape.chunk_samples)) +
           cl::define("RC_MOST_LIGHTS", std::max(1, shape.sun + shape.components + shape.lamps));
  const std::string matter = matter_options(shape.matter), stack = cl::define("RC_STACK", kernel_stack(stack_bound));
  // The plain grid has bundles of its own; where rays go one by one, how samples lie is no matter of the program.
  const bool grid = !shape.moving && shape.sampler == scene::SamplerKind::grid && shape.support_px == 1;
  ProgramOptions out{all + stack + cl::define("RC_GRID", int{grid}), all + stack + matter, "", all + matter};
  if (shape.bounces) out.paths = out.trace + cl::define("RC_SKELETON", path_room(shape.skeleton_padded(), on_cpu));
  return out;
}

static_assert(static_cast<int>(scene::SamplerKind::grid) == RC_SAMPLER_GRID &&
                  static_cast<int>(scene::SamplerKind::lattice) == RC_SAMPLER_LATTICE &&
                  static_cast<int>(scene::SamplerKind::jittered) == RC_SAMPLER_JITTERED,
              "sampler numbers are those of kernels/sampling/sampler.h");

namespace {

/// Bytes that a pixel adds to the largest single buffer, which must stay inside one allocation.
std::size_t largest_buffer(const StageShape& shape, std::size_t capacity) {
  const shared::TileElements tile = shape.tile();
  return std::max({std::max({tile.surface, tile.met_sky, tile.glow}) * sizeof(float),
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
  throw base::Error(base::Fault::input, std::string("--memory is too small for ") + what + ": need " +
                                            std::to_string(need) + " bytes, found " + std::to_string(memory_bytes) +
                                            "; raise --memory, or lower the samples per pixel, the number of bands "
                                            "(band_truth adds as many for each of its "
                                            "cubes) or the pixels of a line");
}

TileSize choose_tile_size(const StageShape& shape, int pixels, int lines, std::size_t capacity,
                          std::size_t budget_bytes, std::size_t tile_samples, std::size_t max_alloc_bytes,
                          int forced_lines, const LeastMemory& least) {
  const std::size_t per_pixel = shape.pixel_bytes() + shape.row_bytes(capacity) + least.more_bytes;
  const std::size_t largest = largest_buffer(shape, capacity);
  constexpr std::size_t kFewestSamples =
      32;  // an image of a few samples a pixel fills its memory with bands, not with samples
  const std::size_t useful = tile_samples / std::max(kFewestSamples, shape.tile().padded);
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
