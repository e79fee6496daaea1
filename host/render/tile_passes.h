// Tiles of one instrument, each in one pass or, where its samples are adaptive, after a look: few samples,
// without rays to the sky, in all its pixels and one pixel around say which groups need all samples
// (adaptive.h); the others are rendered with the few. Which those are does not depend on the tiles. The look
// leaves out the sky since a walk towards it costs nearly the same for few samples as for many.
//
// Where the instrument's small objects are on, groups of pixels that hold some that their samples cannot tell
// are rendered anew with as many as they need (host/sensors/small_objects.h), radiance and truth alike;
// workers for those counts are made when the first such group comes.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "host/render/tile_worker.h"
#include "host/sensors/small_objects.h"

namespace raycube::render {

class TilePasses {
 public:
  /// For tiles of at most lines x columns pixels.
  TilePasses(const RenderSetup& setup, int lines, int columns, std::size_t row_capacity, std::size_t table_bytes);
  ~TilePasses();

  /// Renders a tile, standard-error layers included where `out` has them (its band_error may be null even so), all its
  /// replicates and small objects. A probe has hits and visibilities of pixels that are no means of replicates.
  void run(const Tile& tile, TileOutput out, PixelProbe* probe = nullptr);

  /// One replicate of a tile, without what small objects need.
  void run_replicate(int replicate, const Tile& tile, const TileOutput& out);

  /// Renders the tile's groups with small objects anew.
  void run_small_objects(const Tile& tile, const TileOutput& out);

  /// Another draw of samples and sky rays for rays that are listed.
  void set_draw(const PixelDraw& draw) { full_.set_draw(draw); }

  /// Renders rays of any groups in one pass with all samples. Adaptive ones and small objects need their tile.
  void run_listed(const TileRays& rays, const TileOutput& out, PixelProbe* probe);

  RenderStatistics statistics() const;

 private:
  void run_adaptive(const Tile& tile, const TileOutput& out);
  /// The mean of the tile's replicates.
  void run_replicates(const Tile& tile, const TileOutput& out);
  /// A worker for so many samples a pixel, of sensors::kFineLevels.
  struct Fine;
  Fine& fine(int samples);
  /// One pass over rays, the layer of standard errors included where `out` has it.
  void run_pass(TileWorker& worker, const TileRays& rays, const TileOutput& out, PixelProbe* probe);
  /// The same over some groups of a tile, each filed from its first pixel in the tile on.
  void run_groups(TileWorker& worker, const Tile& tile, const std::vector<shared::RayGroup>& groups,
                  const std::vector<std::size_t>& first_pixel, const TileOutput& out);
  /// error_scale of the band means over a few hashed pixels of the image, the same for any tiles.
  const std::vector<float>& scale();
  std::vector<shared::RayGroup> groups_of(int first_line, int lines, int first_group, int groups) const;

  RenderSetup setup_;
  std::size_t layers_;                               ///< of the scene, all shares; standard errors follow
  std::optional<sensors::SmallObjectPixels> small_;  ///< none: nothing of the scene needs more samples
  std::size_t fine_bytes_;                           ///< of the table's, for tiles of pixels with more samples
  BandTable table_;
  std::unique_ptr<scene::Instrument> coarse_instrument_;
  std::optional<TileWorker> look_, coarse_;
  TileWorker full_;
  std::size_t most_groups_;  ///< of a tile
  std::vector<float> scale_;
  ReplicateSpread spread_;
  std::uint64_t refined_pixels_ = 0, adaptive_pixels_ = 0;
  std::size_t row_capacity_;
  std::map<int, std::unique_ptr<Fine>> fine_;  ///< by samples
  std::map<int, std::uint64_t> fine_pixels_;   ///< rendered so
};

/// What a render of this instrument must hold at once, standard errors and the first pass with it.
LeastMemory least_memory(const scene::CompiledScene& scene, const scene::Instrument& instrument, const plan::Plan& plan,
                         std::size_t row_capacity);

}  // namespace raycube::render
