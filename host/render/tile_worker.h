// One tile from rays to finished radiance and truth, overflow included.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/render/band_table.h"
#include "host/render/renderer.h"
#include "host/render/row_stages.h"
#include "host/render/trace_stages.h"

namespace raycube::render {

/// Everything that stays the same from tile to tile of one render.
struct RenderSetup {
  const cl::Context& context;
  const scene::CompiledScene& scene;
  sensors::KnownObjects& objects;
  const SceneBuffers& buffers;
  const scene::Instrument& instrument;
  const plan::Plan& plan;
  const scene::Sun& sun;
  std::uint64_t seed;
  StageShape shape;
};

/// What becomes of a tile: arrays of the caller's, pixels in line order.
struct TileOutput {
  float* radiance = nullptr;  ///< [pixel][column]: bands, then truth per band (plan::Plan::columns)
  float* truth =
      nullptr;  ///< [pixel][layers]; of them those of truth_layer_names(scene) are filled, and shares that are opaque
  std::size_t layers = 0;
  float* band_error = nullptr;  ///< [pixel][column], standard error (standard_error.h); NaN: not known. Or not wanted
  PixelTerms* terms = nullptr;  ///< [pixel], what the radiance is the sum of, in its order. Or not wanted
};

/// Files the hits of one chunk of the tile's samples in the probe.
void collect_hits(const StageShape& shape, int chunk, const TraceBuffers& traced, HitProbe& probe);

class TileWorker {
 public:
  /// Buffers for tiles of at most `pixels` pixels in at most `lines` lines. `table`: of the setup's plan. errors:
  /// standard errors may be asked for.
  TileWorker(const RenderSetup& setup, BandTable& table, std::size_t pixels, int lines, std::size_t row_capacity,
             bool errors);

  /// Renders a tile. Fills `probe` when given; its tile is set.
  void run(const TileRays& rays, const TileOutput& out, PixelProbe* probe = nullptr);

  /// Another draw of samples and sky rays from here on.
  void set_draw(const PixelDraw& draw) { trace_stages_.set_draw(draw); }

  const RenderStatistics& statistics() const { return statistics_; }
  /// Terms per pixel seen so far, as a histogram (index = number of terms, clamped).
  const std::vector<std::uint64_t>& term_histogram() const { return term_histogram_; }

 private:
  /// Resolves and integrates the items of `rows`; writes their truth unless `out` has none; returns the tile pixels
  /// that overflowed.
  std::vector<std::uint32_t> finish_rows(RowBuffers& rows, const std::vector<std::uint32_t>& pixels, bool use_list,
                                         const TileOutput& out);
  /// Finishes `rows` of all pixels and launches those that overflow anew with more room; returns those that need still
  /// more.
  std::vector<std::uint32_t> finish_all(RowBuffers& rows, const std::vector<std::uint32_t>& pixels, int subset,
                                        const TileOutput& out);
  /// Radiance of each part of the samples, and their spread about the whole's.
  void add_errors(const std::vector<std::uint32_t>& pixels, const TileOutput& out);
  /// Rows of the band table and weights of the items' environment; every node of theirs is in the table.
  void write_environment(std::span<const std::array<plan::EnvironmentWeight, 4>> around, std::size_t first_item,
                         RowBuffers& rows);
  /// The same for a pixel summed on the host; path: its weights at the height nodes. Terms: null, or where they go too.
  void add_environment(std::uint32_t pixel, const float* truth_sums, const std::vector<double>& path,
                       std::vector<double>& radiance, PixelTerms* terms) const;
  /// The lower of the plan's two view nodes around a pixel's centre ray, and the other's weight.
  std::pair<int, float> view_nodes(std::uint32_t pixel) const;
  /// Light between surfaces of such a pixel.
  void add_glow(std::uint32_t pixel, const std::vector<double>& path, std::vector<double>& radiance,
                PixelTerms* terms) const;
  /// The terms that resolve left of `count` items of `rows`, from the first on, for their pixels.
  void file_terms(std::size_t first, std::size_t count, const std::vector<std::uint32_t>& pixels, RowBuffers& rows,
                  PixelTerms* terms) const;
  std::vector<std::uint32_t> relaunch(const std::vector<std::uint32_t>& flagged, std::size_t capacity, int subset,
                                      const TileOutput& out);
  void sum_per_sample(const std::vector<std::uint32_t>& flagged, const TileOutput& out);
  /// Of a row that a key's light belongs to: whose abundance it counts.
  std::size_t material_of_key(std::uint64_t key) const;
  void write_truth(std::uint32_t pixel, const float* sums, const float* abundance, const TileOutput& out);
  /// Whether shares of what is opaque are asked for, and there is a place for them.
  bool fills_opaque(const TileOutput& out) const;
  /// Adds what a chunk's rays meet first of what lets no light through; shares: [pixel][material].
  void add_first_opaque(int chunk, std::vector<double>& shares);
  /// Files them; without leaves they are the abundances.
  void write_first_opaque(const std::vector<double>& shares, const TileOutput& out) const;
  /// Files what the stages left of one chunk of samples.
  void collect(int chunk, PixelProbe& probe) const;
  void collect_paths(PixelProbe& probe) const;
  std::array<double, 3> centre_direction(std::uint32_t pixel) const;
  /// Nodes of the environment map around the mean of a pixel's hit points; around where its centre ray meets the lowest
  /// height when it hits nothing.
  std::array<plan::EnvironmentWeight, 4> environment_of(std::uint32_t pixel, const float* truth_sums) const;
  template <class Action>
  void timed(const std::string& stage, Action action);

  RenderSetup setup_;
  RowStages row_stages_;
  TraceStages trace_stages_;
  BandTable& table_;
  TraceBuffers traced_;
  RowBuffers rows_;
  std::vector<RowBuffers>
      subset_rows_;  ///< of the parts of samples that come in chunks; else rows_ serves them one by one
  cl::Buffer<float> radiance_;
  std::optional<cl::Buffer<std::uint32_t>> opaque_;  ///< of a chunk, where they are traced
  TileLayout layout_;
  std::vector<shared::RayGroup> groups_;
  bool all_baked_;
  std::vector<std::uint32_t> named_;  ///< scene::named_materials
  RenderStatistics statistics_;
  std::vector<std::uint64_t> term_histogram_;
  std::vector<std::pair<std::uint32_t, std::vector<double>>> host_radiance_;  ///< pixels summed on the host
};

}  // namespace raycube::render
