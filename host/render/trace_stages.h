// The tracing stages of a tile: primary rays, surface points, sun, sky.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "host/cl/kernel.h"
#include "host/render/row_stages.h"
#include "host/render/tile_shape.h"

namespace raycube::render {

/// Where a tile lies in the image: what random numbers are keyed by.
struct TilePlace {
  std::uint32_t first_line = 0, first_column = 0, lines = 0;
};

/// The instrument's groups that a tile's pixels belong to, line by line.
std::vector<shared::RayGroup> tile_groups(const scene::Instrument& instrument, const Tile& tile, int pixels_per_group);

class TraceStages {
 public:
  TraceStages(const cl::Context& context, const scene::CompiledScene& scene, const SceneBuffers& buffers,
              const scene::Instrument& instrument, const plan::Plan& plan, const StageShape& shape, std::uint64_t seed);
  ~TraceStages();

  /// Traces one chunk of samples of every pixel of the tile into `traced`. Adds the stages' wall seconds to `stage_s`.
  void run(const TilePlace& place, const TileLayout& layout, int chunk, TraceBuffers& traced,
           std::map<std::string, double>& stage_s);

  /// Only the primary rays of that chunk: traced.hits.
  void run_primary(const TilePlace& place, const TileLayout& layout, int chunk, TraceBuffers& traced);

  /// Text that program hashes cover: names, options and sources.
  const std::string& identity() const;
  /// SHA-256 of identity().
  std::string program_hash() const;
  const std::string& options() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 of what both launch: `program_hash` of a run.
std::string program_hash(const TraceStages& trace, const RowStages& rows);

}  // namespace raycube::render
