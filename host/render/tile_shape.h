// How an image is cut into tiles and a pixel's samples into chunks, so that memory follows the budget and never the
// number of pixels or samples.
#pragma once

#include <cstddef>
#include <cstdint>

#include <algorithm>
#include <string>

#include "host/plan/plan.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/simulation.h"

namespace raycube::render {

/// Samples are traced in chunks of at most this many per pixel; more are accumulated chunk by chunk.
inline constexpr int kMaxChunkSamples = 1024;

/// Keys that a row of a pixel holds whose samples come in chunks: it cannot be relaunched.
inline constexpr std::size_t kChunkedCapacity = 256;

/// The sizes that every stage works with.
struct StageShape {
  int samples = 1;                                        ///< of a pixel, all chunks
  int samples_u = 1, samples_v = 1;                       ///< along and across the line
  scene::SamplerKind sampler = scene::SamplerKind::grid;  ///< where they lie
  float support_px = 1;                                   ///< width of the square that they cover
  bool moving = false;                                    ///< the pose changes while a line is taken
  int chunk_samples = 0;                                  ///< of one chunk (the last chunk may hold fewer)
  int chunks = 1;
  int pixels_per_group = RC_GROUP_WIDTH;
  int sun = 1, components = 0, thermal_components = 0, lamps = 0, temperatures = 0;  ///< sources of a material row
  int heights = 1, views = 1, path_x = 1, path_y = 1;
  int channels = 1;           ///< rows of the band table per key: max of source and path channels
  bool first_opaque = false;  ///< what is opaque behind leaves is traced for truth
  bool covers = false;        ///< a material's coverage is a term: there is truth per band
  int bands = 0;              ///< values of a pixel: bands, then those of truth per band
  int bands_padded = 0;
  bool sky_shadows = true;  ///< false: nothing hides the sky, no rays are sent to it
  scene::CameraMatter matter;
  bool lambertian = false;     ///< all reflects by Lambert's law here, whatever the program could do
  bool lobe_albedo = false;    ///< emission goes by the angle
  bool bounces = false;        ///< light comes by surfaces after the first
  int skeleton = 0;            ///< wavelengths along its paths
  std::size_t path_steps = 0;  ///< of a pixel, that are handed over; 0: none are
  bool environment = false;    ///< light of the ground around joins: 4 rows of the band table per pixel
  bool chunked() const { return chunks > 1; }
  int sources() const { return sun + components + lamps + temperatures; }
  int skeleton_padded() const { return std::max(RC_PADDED(skeleton), RC_WORD); }
  int sky_planes() const { return RC_SKY_PLANES_OF(components + lamps); }
  int accumulators() const { return RC_ROW_ACCUMULATORS(sources(), heights); }
  /// Elements of a pixel in the buffers of a chunk.
  shared::TileElements tile() const {
    return {static_cast<std::size_t>(chunk_samples), static_cast<std::size_t>(sky_planes()), matter.shaped,
            static_cast<std::size_t>(matter.sides()),
            bounces ? static_cast<std::size_t>((1 + lamps) * skeleton_padded()) : 0};
  }
  /// The same as kernels are told.
  shared::TileShape arguments() const;
  /// Elements of an item in the buffers of rows.
  shared::RowElements rows(std::size_t capacity) const {
    return {capacity, static_cast<std::size_t>(accumulators()), static_cast<std::size_t>(heights), chunked()};
  }
  /// Terms a pixel with `capacity` keys can have.
  std::size_t term_capacity(std::size_t capacity) const {
    return static_cast<std::size_t>(heights) * path_x * path_y +
           (environment ? RC_ENVIRONMENT_NODES * static_cast<std::size_t>(heights) * views : 0) +
           (bounces ? static_cast<std::size_t>((1 + lamps) * skeleton) * heights * views : 0) +
           capacity * (static_cast<std::size_t>(sources()) * heights * views + (covers ? 1 : 0));
  }
  /// Device bytes of a pixel's row, terms and counts at a given key capacity.
  std::size_t row_bytes(std::size_t capacity) const;
  /// Device bytes of everything else a pixel needs: hits, points, visibility, sky, sums, radiance.
  std::size_t pixel_bytes() const;
};

/// Keys that a pixel's row holds, for samples at once or in chunks. given: RenderOptions::row_capacity.
inline std::size_t row_capacity_of(const StageShape& shape, int given) {
  return shape.chunked() ? kChunkedCapacity : static_cast<std::size_t>(given);
}

/// A scene that has BSDFs which change with wavelength is always rendered by the programs that know them, so that a
/// plan without them (planner::measure_open_share) compiles no others; then lambertian is set. Throws Error(input) when
/// the sampler cannot be cut into chunks (a grid wider than kMaxChunkSamples).
StageShape make_stage_shape(const scene::Instrument& instrument, const plan::Plan& plan, int pixels_per_group);

/// Build options of a camera's programs.
struct ProgramOptions {
  std::string primary;  ///< of kernels/entry/trace_primary.cl: rays to the first surface
  std::string trace;    ///< of kernels/entry/trace_light.cl: from there to sun, sky and lamps
  std::string paths;    ///< of kernels/entry/trace_bounce.cl: light between surfaces; empty where there is none
  std::string rows;     ///< of kernels/entry/rows.cl: shading and what follows
};

/// Few: every option is another compilation, and what images differ in by number is in StageShape::arguments().
/// stack_bound: CompiledScene::stack_bound(); on_cpu: a kernel's own arrays have room for the largest image, which
/// costs nothing there; elsewhere for this one. Options of the scene's arrays (SceneBuffers::options) are not here.
ProgramOptions program_options(const StageShape& shape, std::uint32_t stack_bound, bool on_cpu);

/// Build options of the matter that a scene has, for the kernels of cameras and photons: Lambert's law alone, leaves
/// beside it, or all there is; and further lobes.
std::string matter_options(const scene::CameraMatter& matter);

/// A rectangle of pixels: full-width strips of lines, or parts of one line when a line exceeds the budget.
struct Tile {
  int first_line = 0, lines = 0, first_column = 0, columns = 0;
  std::size_t pixels() const { return static_cast<std::size_t>(lines) * columns; }
};

/// Largest tile the budget allows: lines of full width, else columns of one line (a multiple of 4).
struct TileSize {
  int lines = 1;
  int columns = 0;
};

/// Of --memory, which bounds them together, a third is for the tile's device buffers, a third for baked rows,
/// a third for strips on their way out.
inline constexpr std::size_t kBudgetShares = 3;

/// Band-table rows of one pixel, all of which must be baked at once: 256 keys, its environment's four and the
/// path.
inline constexpr std::size_t kFewestRows = 261;

/// What a render must hold at once whatever the budget.
struct LeastMemory {
  std::size_t strip_values =
      0;  ///< floats of a pixel on its way out: columns (twice with their standard errors) and truth layers
  std::size_t table_rows = 0;  ///< the band table's: kFewestRows, or all there can be
  std::size_t more_bytes = 0;  ///< of a pixel on the device, beside the shape's
  std::size_t fine_bytes = 0;  ///< of the pixels of small objects, beside the band table's rows
};

/// Throws Error(input) that names the least --memory when a third of `memory_bytes` holds less than a group
/// of pixels, the waiting strips of one line, or one pixel's rows of the band table with a group of pixels for
/// every count of samples that small objects may ask for.
void require_memory(const StageShape& shape, const LeastMemory& least, int pixels, std::size_t capacity,
                    std::size_t memory_bytes);

/// Strips that exist at once on the host: one being filled, two waiting, one being written.
inline constexpr std::size_t kStripsAtOnce = 4;

/// budget_bytes: what --memory grants for tiles, 1 / kBudgetShares of it; tile_samples: of the largest launch worth its
/// memory (DeviceTuning); max_alloc_bytes: the device's largest buffer; forced_lines > 0 overrides; Throws Error(input)
/// with need, limit and ways out when not even four pixels fit.
TileSize choose_tile_size(const StageShape& shape, int pixels, int lines, std::size_t capacity,
                          std::size_t budget_bytes, std::size_t tile_samples, std::size_t max_alloc_bytes,
                          int forced_lines, const LeastMemory& least);

}  // namespace raycube::render
