// Tiles of one instrument, each in one pass or, where its samples are adaptive, in two: few samples in all its pixels and one pixel
// around, then all samples in the groups that need them (adaptive.h). Which those are does not depend on the tiles.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/render/tile_worker.h"

namespace raycube::render {

class TilePasses {
 public:
  /// For tiles of at most lines x columns pixels.
  TilePasses(const RenderSetup& setup, int lines, int columns, std::size_t row_capacity, std::size_t table_bytes);

  /// Renders a tile, standard-error layers included where `out` has them (its band_error may be null even so).
  void run(const Tile& tile, TileOutput out, PixelProbe* probe = nullptr);

  RenderStatistics statistics() const;

 private:
  void run_adaptive(const Tile& tile, const TileOutput& out);
  void run_full(const TileRays& rays, const TileOutput& out, PixelProbe* probe);
  /// error_scale of the band means over a few hashed pixels of the image, the same for any tiles.
  const std::vector<float>& scale();
  std::vector<shared::RayGroup> groups_of(int first_line, int lines, int first_group, int groups) const;

  RenderSetup setup_;
  std::size_t layers_;                ///< of the scene; standard errors follow
  BandTable table_;
  std::unique_ptr<scene::Instrument> coarse_instrument_;
  std::optional<TileWorker> coarse_;
  TileWorker full_;
  std::size_t most_groups_;           ///< of a tile
  std::vector<float> scale_;
  std::uint64_t refined_pixels_ = 0, adaptive_pixels_ = 0;
};

/// Device bytes of a pixel beside those of StageShape, for standard errors and the first pass.
std::size_t more_pixel_bytes(const scene::Instrument& instrument, const plan::Plan& plan, std::size_t row_capacity);

}  // namespace raycube::render
