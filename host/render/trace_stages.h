// The tracing stages of a tile: primary rays, surface points, sun, sky, paths between surfaces.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/cl/kernel.h"
#include "host/render/row_stages.h"
#include "host/render/tile_shape.h"
#include "host/render/types.h"

namespace raycube::render {

/// The groups that pixels belong to and where the pixels lie in them. A tile's come line by line; any list of groups is
/// a tile too, each group a line of its own.
struct TileRays {
  std::vector<shared::RayGroup> groups;
  TileLayout layout;
  std::size_t pixels() const { return static_cast<std::size_t>(layout.lines) * layout.columns; }
};
TileRays tile_rays(const scene::Instrument& instrument, const scene::CompiledScene& scene, const Tile& tile,
                   int pixels_per_group);
/// The last group of an image's line may bring pixels past its end; they are rendered like any other.
TileRays listed_rays(std::vector<shared::RayGroup> groups, int pixels_per_group);

class TraceStages {
 public:
  /// weights: of a pixel's samples; without them all alike.
  TraceStages(const cl::Context& context, const scene::CompiledScene& scene, const SceneBuffers& buffers,
              const plan::Plan& plan, const StageShape& shape, std::uint64_t seed,
              std::optional<sensors::SampleWeights> weights = {});
  ~TraceStages();

  /// Traces one chunk of samples of every pixel of the tile into `traced`. Adds the stages' wall seconds to `stage_s`.
  void run(const TileLayout& layout, int chunk, TraceBuffers& traced, std::map<std::string, double>& stage_s);

  /// Of the chunk that run has traced: the first primitive on each sample's ray that lets no light through,
  /// [pixel][slot of the near side]; the shape has first_opaque.
  void run_first_opaque(const TileLayout& layout, int chunk, const TraceBuffers& traced,
                        cl::Buffer<std::uint32_t>& opaque);

  /// Only the primary rays of that chunk: traced.hits.
  void run_primary(const TileLayout& layout, int chunk, TraceBuffers& traced);

  /// Another draw of samples, sky rays and paths from here on.
  void set_draw(const PixelDraw& draw);

  /// Text that program hashes cover: names, options and sources.
  const std::string& identity() const;
  /// SHA-256 of the same as it is where no ray goes to the sky: what primary and sun rays run.
  std::string program_hash() const;
  /// Build options of the programs of rays to the first surface, of rays from there, and of paths where there are any.
  std::vector<std::string> variants() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 of what both launch: `program_hash` of a run.
std::string program_hash(const TraceStages& trace, const RowStages& rows);

}  // namespace raycube::render
