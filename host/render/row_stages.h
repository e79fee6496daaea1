// The stages after tracing: shade, resolve, integrate_bands, and the rows they pass on.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/cl/kernel.h"
#include "host/render/band_table.h"
#include "host/render/scene_buffers.h"
#include "host/render/tile_shape.h"
#include "host/sensors/psf.h"

namespace raycube::render {

/// Rows, terms and sums of `items` pixels at one key capacity.
struct RowBuffers {
  RowBuffers(const cl::Context& context, const StageShape& shape, std::size_t items, std::size_t capacity);
  std::size_t items, capacity, term_capacity;
  shared::RowElements elements;  ///< of an item
  cl::Buffer<std::uint32_t> count;
  cl::Buffer<std::uint64_t> keys;
  cl::Buffer<float> sums;
  cl::Buffer<float> path;
  cl::Buffer<float> truth;
  cl::Buffer<std::uint32_t> environment_row;  ///< [item][RC_ENVIRONMENT_NODES], of the band table
  cl::Buffer<float> environment_weight;       ///< [item][RC_ENVIRONMENT_NODES]
  cl::Buffer<std::uint32_t> term_count;
  cl::Buffer<std::uint32_t> term_row;
  cl::Buffer<float> term_weight;
  int subset = sensors::kAllSamples;  ///< of the samples that were shaded into it
};

/// What tracing left of a tile (or of one chunk of its samples).
struct TraceBuffers {
  TraceBuffers(const cl::Context& context, const StageShape& shape, std::size_t pixels, std::size_t groups);
  shared::TileElements elements;  ///< of a pixel
  cl::Buffer<shared::RayGroup> groups;
  cl::Buffer<std::uint32_t> hits;
  cl::Buffer<float> surface, lift;
  cl::Buffer<std::uint16_t> sun;
  cl::Buffer<float> met_sky;
  cl::Buffer<float> glow;
  cl::Buffer<shared::PathStep> path_log;
};

/// Share of the open sky that each surface takes for granted: the plan's, or all of it where no rays are sent.
std::vector<float> open_shares(const SceneBuffers& scene, const plan::Plan& plan, const StageShape& shape);

/// Pixels a launch works on: the first `count` of a tile, or those of a list.
struct PixelSelection {
  std::uint32_t count = 0;
  const cl::Buffer<std::uint32_t>* list = nullptr;
};

/// Where a tile's pixels lie in its groups.
struct TileLayout {
  std::uint32_t columns = 0;  ///< pixels of a line of the tile
  std::uint32_t lines = 0;
  std::uint32_t pixels_per_group = RC_GROUP_WIDTH;
  std::size_t groups() const {
    return static_cast<std::size_t>(lines) * shared::rc_groups_per_line(columns, pixels_per_group);
  }
  std::size_t group_of(std::uint32_t pixel) const { return shared::rc_group_of(pixel, columns, pixels_per_group); }
  float place_in_group(std::uint32_t pixel) const {
    return shared::rc_place_in_group(pixel, columns, pixels_per_group);
  }
};

/// The three kernels, specialised for one shape, and the plan data they read.
class RowStages {
 public:
  RowStages(const cl::Context& context, const SceneBuffers& scene, const plan::Plan& plan, const StageShape& shape,
            sensors::SampleWeights weights);

  /// subset: one part of the samples (host/sensors/psf.h), or all of them.
  void shade(const PixelSelection& pixels, const TileLayout& layout, const TraceBuffers& traced, int chunk, int subset,
             bool fresh, RowBuffers& rows);
  /// Items first_item .. first_item + item_count - 1 of the selection; every key of theirs is in the table.
  void resolve(std::uint32_t first_item, std::uint32_t item_count, const PixelSelection& pixels,
               const TileLayout& layout, const TraceBuffers& traced, const BandTable& table, RowBuffers& rows);
  void integrate(std::uint32_t first_item, std::uint32_t item_count, const PixelSelection& pixels,
                 const BandTable& table, const RowBuffers& rows, cl::Buffer<float>& radiance);

  /// Text that the program hash covers: names, options and sources.
  const std::string& identity() const { return identity_; }
  const std::string& options() const { return options_; }

 private:
  const cl::Context& context_;
  const SceneBuffers& scene_;
  const plan::Plan& plan_;
  StageShape shape_;
  shared::TileShape tile_;
  std::string options_, identity_;
  std::shared_ptr<const cl::Program> program_;
  cl::Kernel shade_, resolve_, integrate_;
  sensors::SampleWeights weights_;
  cl::Buffer<float> sample_weight_;  ///< of one chunk, zero in the padding
  int loaded_chunk_ = -1, loaded_subset_ = -1;
  cl::Buffer<shared::rc_float4> irradiance_, tilt_irradiance_, surface_node_;
  cl::Buffer<std::uint32_t> albedo_at_;
  cl::Buffer<float> albedo_;
  cl::Buffer<float> open_share_;
  cl::Buffer<std::uint32_t> no_list_;
};

}  // namespace raycube::render
