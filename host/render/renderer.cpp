#include "host/render/renderer.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/sha256.h"
#include "host/base/timing.h"
#include "host/render/scene_on_device.h"
#include "host/render/tile_passes.h"
#include "host/render/truth.h"
#include "host/sensors/ray_groups.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

namespace {

/// Finished strips on their way to the sink: one thread writes while the device traces. At most two wait, so that
/// memory stays bounded; an error in the sink surfaces in push() or finish().
class StripQueue {
 public:
  struct Item {
    Strip strip;
    std::vector<float> radiance, truth, band_error;
  };
  explicit StripQueue(const StripSink& sink) : sink_(sink), thread_([this] { drain(); }) {}
  ~StripQueue() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
      items_.clear();
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  /// An item of these sizes, of memory that a strip before it had where there is one: fresh pages cost as much as
  /// filling them. The radiance holds anything, all else zeros.
  Item take(std::size_t radiance, std::size_t truth, std::size_t band_error) {
    Item item;
    {
      const std::lock_guard lock(mutex_);
      if (!written_.empty()) item = std::move(written_.back()), written_.pop_back();
    }
    item.radiance.resize(radiance);
    item.truth.assign(truth, 0.0f);
    item.band_error.assign(band_error, 0.0f);
    item.strip = {};
    return item;
  }
  void push(Item item) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return items_.size() < 2 || error_; });
    if (error_) std::rethrow_exception(error_);
    items_.push_back(std::move(item));
    changed_.notify_all();
  }
  /// Waits until every strip has been written. Returns the seconds the sink took.
  double finish() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
    thread_.join();
    if (error_) std::rethrow_exception(error_);
    return seconds_;
  }

 private:
  void drain() {
    for (;;) {
      Item item;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !items_.empty() || closed_; });
        if (items_.empty()) return;
        item = std::move(items_.front());
        items_.pop_front();
      }
      changed_.notify_all();
      try {
        const auto start = std::chrono::steady_clock::now();
        item.strip.radiance = item.radiance.data();
        item.strip.truth = item.truth.data();
        if (!item.band_error.empty()) item.strip.band_error = item.band_error.data();
        sink_(item.strip);
        seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const std::lock_guard lock(mutex_);
        written_.push_back(std::move(item));
      } catch (...) {
        const std::lock_guard lock(mutex_);
        error_ = std::current_exception();
        items_.clear();
        closed_ = true;
        changed_.notify_all();
        return;
      }
    }
  }

  const StripSink& sink_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> items_;
  std::vector<Item> written_;
  std::exception_ptr error_;
  bool closed_ = false;
  double seconds_ = 0;
  std::thread thread_;
};

/// What tiles that are rendered together may take of the device's memory.
constexpr std::size_t kTogether_bytes = std::size_t{32} << 20;

std::size_t groups_of(const Tile& tile, std::size_t width) {
  return static_cast<std::size_t>(tile.lines) * ((static_cast<std::size_t>(tile.columns) + width - 1) / width);
}

/// Appends a tile's pixels of a lot whose groups begin with this one; returns the group after them.
template <class Value>
std::size_t append_pixels(const std::vector<Value>& lot, std::size_t of_pixel, const Tile& tile, std::size_t group,
                          std::size_t width, std::vector<Value>& out) {
  const auto columns = static_cast<std::size_t>(tile.columns), per_line = (columns + width - 1) / width;
  for (int line = 0; line < tile.lines; ++line, group += per_line) {
    const auto begin = lot.begin() + static_cast<std::ptrdiff_t>(group * width * of_pixel);
    out.insert(out.end(), begin, begin + static_cast<std::ptrdiff_t>(columns * of_pixel));
  }
  return group;
}

/// A tile's part of a probe of groups, each `width` pixels whether the image has them or not, from its first group on.
PixelProbe part_of(const PixelProbe& together, const Tile& tile, std::size_t first_group, std::size_t width) {
  PixelProbe out;
  out.tile = tile, out.samples = together.samples, out.sides = together.sides;
  const auto first = together.groups.begin() + static_cast<std::ptrdiff_t>(first_group);
  out.groups.assign(first, first + static_cast<std::ptrdiff_t>(groups_of(tile, width)));
  const auto take = [&](const auto& from, auto& to) {
    append_pixels(from, from.size() / together.tile.pixels(), tile, first_group, width, to);
  };
  take(together.hit_instance, out.hit_instance), take(together.hit_primitive, out.hit_primitive);
  take(together.sun_visible, out.sun_visible), take(together.sky_met, out.sky_met);
  take(together.radiance, out.radiance), take(together.truth, out.truth);
  take(together.steps, out.steps), take(together.glow, out.glow);
  return out;
}

}  // namespace

struct Renderer::State : SceneOnDevice {
  using SceneOnDevice::SceneOnDevice;

  RenderSetup setup(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                    std::uint64_t seed) const {
    return {context, scene,      objects,
            buffers, instrument, plan,
            sun,     seed,       make_stage_shape(instrument, plan, sensors::pixels_per_group(instrument))};
  }
  std::size_t row_capacity(const StageShape& shape) const { return row_capacity_of(shape, options.row_capacity); }
};

/// Many small tiles in few launches.
class Renderer::TilesTogether {
 public:
  /// Keeps references.
  TilesTogether(const State& state, const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                std::uint64_t seed, const std::vector<Tile>& tiles)
      : state_(state), instrument_(instrument), tiles_(tiles), setup_(state.setup(instrument_, plan, sun, seed)) {
    // Else every tile would look through all poses.
    instrument_.motion = sensors::pose_moves(instrument) ? scene::PoseMotion::moving : scene::PoseMotion::held;
    const std::size_t group_bytes =
        width() * (setup_.shape.pixel_bytes() + setup_.shape.row_bytes(state.row_capacity(setup_.shape)));
    std::size_t widest = 1, all = 0;
    for (const Tile& tile : tiles) {
      const std::size_t groups = groups_of(tile, width());
      widest = std::max(widest, groups), all += groups;
    }
    most_ = std::max(widest, std::min(all, std::min(kTogether_bytes, state.tile_budget()) / group_bytes));
  }

  std::size_t width() const { return static_cast<std::size_t>(setup_.shape.pixels_per_group); }
  TilePasses passes() const {
    return {setup_, static_cast<int>(most_), static_cast<int>(width()), state_.row_capacity(setup_.shape),
            state_.options.memory_bytes / kBudgetShares};
  }

  /// Rays of as many tiles as fit, with the number of the first and past the last.
  template <class Work>
  void each_lot(const Work& work) const {
    for (std::size_t first = 0, end = 0; first < tiles_.size(); first = end) {
      base::throw_if_interrupted();
      std::vector<shared::RayGroup> groups;
      for (; end < tiles_.size() && groups.size() + groups_of(tiles_[end], width()) <= most_; ++end) {
        const TileRays rays = tile_rays(instrument_, state_.scene, tiles_[end], setup_.shape.pixels_per_group);
        groups.insert(groups.end(), rays.groups.begin(), rays.groups.end());
      }
      work(listed_rays(std::move(groups), setup_.shape.pixels_per_group), first, end);
    }
  }

 private:
  const State& state_;
  scene::Instrument instrument_;
  const std::vector<Tile>& tiles_;
  RenderSetup setup_;
  std::size_t most_ = 1;  ///< groups of a lot
};

Renderer::Renderer(const scene::CompiledScene& scene, const RenderOptions& options)
    : state_(std::make_unique<State>(scene, options)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;

std::size_t Renderer::memory_bytes() const { return state_->options.memory_bytes; }
sensors::KnownObjects& Renderer::objects() { return state_->objects; }
std::string Renderer::device_name() const { return state_->context.device().name(); }
DeviceTuning Renderer::tuning() const { return state_->used_tuning(); }
cl::Context& Renderer::context() { return state_->context; }

TileSize Renderer::tile_size(const scene::Instrument& instrument, const plan::Plan& plan,
                             std::size_t tile_samples) const {
  const StageShape shape = make_stage_shape(instrument, plan, sensors::pixels_per_group(instrument));
  const std::size_t capacity = state_->row_capacity(shape);
  const LeastMemory least = least_memory(state_->scene, instrument, plan, capacity);
  require_memory(shape, least, instrument.pixels, capacity, state_->memory());
  return choose_tile_size(shape, instrument.pixels, instrument.lines, capacity, state_->tile_budget(), tile_samples,
                          state_->context.device().info().max_alloc_bytes, state_->options.tile_lines, least);
}

void Renderer::load_programs(const scene::Instrument& instrument, const plan::Plan& plan) {
  const StageShape shape = make_stage_shape(instrument, plan, sensors::pixels_per_group(instrument));
  const TraceStages trace(state_->context, state_->scene, state_->buffers, plan, shape, 0);
  const RowStages rows(state_->context, state_->buffers, plan, shape, sensors::SampleWeights(instrument));
}

RenderStatistics Renderer::render(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                                  std::uint64_t seed, const StripSink& sink, const ProgressSink& progress,
                                  const RenderedImage* rendered) {
  const base::Doing doing("rendering instrument", instrument.name);
  const RenderSetup setup = state_->setup(instrument, plan, sun, seed);
  const TileSize size = tile_size(instrument, plan, state_->tuning.tile_samples);
  std::optional<TilePasses> passes;
  if (!rendered || instrument.small_objects == scene::SmallObjects::on)
    passes.emplace(setup, size.lines, size.columns, state_->row_capacity(setup.shape), state_->tile_budget());

  const std::size_t bands = setup.shape.bands, layers = truth_layer_names(state_->scene, instrument).size();
  const bool band_errors = instrument.standard_error == scene::StandardError::bands;
  const std::uint64_t all_pixels = static_cast<std::uint64_t>(instrument.lines) * instrument.pixels;
  const DerivedLayers derived(state_->scene, instrument);
  StripQueue queue(sink);
  for (int line = 0; line < instrument.lines; line += size.lines) {
    const int lines = std::min(size.lines, instrument.lines - line);
    const std::size_t pixels = static_cast<std::size_t>(lines) * instrument.pixels;
    StripQueue::Item item = queue.take(pixels * bands, pixels * layers, band_errors ? pixels * bands : 0);
    item.strip.first_line = line, item.strip.lines = lines, item.strip.columns = bands;
    if (rendered)
      rendered->sums.mean(static_cast<std::size_t>(line) * instrument.pixels, pixels, item.radiance.data(),
                          item.truth.data(), layers);
    for (int column = 0; column < instrument.pixels; column += size.columns) {
      base::throw_if_interrupted();
      const Tile tile{line, lines, column, std::min(size.columns, instrument.pixels - column)};
      const TileOutput out{item.radiance.data() + column * bands, item.truth.data() + column * layers, layers,
                           band_errors ? item.band_error.data() + column * bands : nullptr};
      if (!rendered)
        passes->run(tile, out);
      else if (passes)
        passes->run_small_objects(tile, out);
      if (progress)
        progress(static_cast<std::uint64_t>(line) * instrument.pixels + tile.first_column * std::uint64_t(lines) +
                     tile.pixels(),
                 all_pixels);
    }
    derived.fill(pixels, item.truth.data());
    queue.push(std::move(item));
  }
  RenderStatistics statistics = rendered ? rendered->statistics : passes->statistics();
  if (rendered && passes) {
    const RenderStatistics small = passes->statistics();
    add_counts(statistics, small);
    statistics.small_object_pixels = small.small_object_pixels;
  }
  statistics.stage_s["write"] = queue.finish();
  statistics.tile_lines = size.lines;
  statistics.tile_columns = size.columns;
  return statistics;
}

RenderedImage Renderer::no_replicates(const scene::Instrument& instrument) const {
  const std::size_t pixels = static_cast<std::size_t>(instrument.lines) * static_cast<std::size_t>(instrument.pixels);
  return {ReplicateSums(pixels, instrument.bands.size(), scene::named_count(state_->scene),
                        scene::named_count(state_->scene)),
          {}};
}

void Renderer::add_replicates(const scene::Instrument& given, const plan::Plan& plan, const scene::Sun& sun,
                              std::uint64_t seed, int count, RenderedImage& image, const ProgressSink& progress) {
  const base::Doing doing("rendering instrument", given.name);
  const auto start = std::chrono::steady_clock::now();
  const double processor_before_s = base::processor_seconds();
  if (!plan.truth.empty()) throw base::Error(base::Fault::bug, "replicates of a trial have no truth per band");
  scene::Instrument instrument = given;
  instrument.small_objects = scene::SmallObjects::off, instrument.first_opaque = false;
  const RenderSetup setup = state_->setup(instrument, plan, sun, seed);
  const TileSize size = tile_size(instrument, plan, state_->tuning.tile_samples);
  TilePasses passes(setup, size.lines, size.columns, state_->row_capacity(setup.shape), state_->tile_budget());
  const auto wide = static_cast<std::size_t>(instrument.pixels);
  const std::size_t bands = setup.shape.bands, layers = truth_layer_names(state_->scene).size();
  std::vector<float> radiance, truth;
  for (int n = 0; n < count; ++n) {
    for (int line = 0; line < instrument.lines; line += size.lines)
      for (int column = 0; column < instrument.pixels; column += size.columns) {
        base::throw_if_interrupted();
        const Tile tile{line, std::min(size.lines, instrument.lines - line), column,
                        std::min(size.columns, instrument.pixels - column)};
        const auto columns = static_cast<std::size_t>(tile.columns);
        radiance.resize(tile.pixels() * bands), truth.assign(tile.pixels() * layers, 0.0f);
        passes.run_replicate(image.sums.count(), tile, {radiance.data(), truth.data(), layers, nullptr});
        for (std::size_t l = 0; l < static_cast<std::size_t>(tile.lines); ++l)
          image.sums.add((static_cast<std::size_t>(line) + l) * wide + static_cast<std::size_t>(column), columns,
                         radiance.data() + l * columns * bands, truth.data() + l * columns * layers, layers);
      }
    image.sums.next();
    if (progress) progress(static_cast<std::uint64_t>(n) + 1, static_cast<std::uint64_t>(count));
  }
  RenderStatistics statistics = passes.statistics();
  add_counts(statistics, image.statistics);
  image.statistics = std::move(statistics);
  image.render_s += base::seconds_since(start);
  image.processor_s += base::processor_seconds() - processor_before_s;
}

RenderStatistics Renderer::probe(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                                 std::uint64_t seed, const std::vector<Tile>& tiles, const ProbeSink& sink) {
  const base::Doing doing("rendering tiles of instrument", instrument.name);
  const RenderSetup setup = state_->setup(instrument, plan, sun, seed);
  int columns = 1, lines = 1;
  for (const auto& tile : tiles) {
    columns = std::max(columns, tile.columns);
    lines = std::max(lines, tile.lines);
  }
  TilePasses passes(setup, lines, columns, state_->row_capacity(setup.shape),
                    state_->options.memory_bytes / kBudgetShares);
  const std::size_t layers = truth_layer_names(state_->scene).size();
  for (const auto& tile : tiles) {
    base::throw_if_interrupted();
    PixelProbe probe;
    probe.tile = tile;
    probe.radiance.resize(tile.pixels() * setup.shape.bands);
    probe.truth.resize(tile.pixels() * layers);
    passes.run(tile, {probe.radiance.data(), probe.truth.data(), layers, nullptr}, sink ? &probe : nullptr);
    if (sink) sink(probe);
  }
  return passes.statistics();
}

Renderer::PixelParts Renderer::parts_of(const scene::Instrument& instrument, const plan::Plan& plan,
                                        const scene::Sun& sun, std::uint64_t seed, int line, int sample) {
  const base::Doing doing("rendering a pixel of instrument", instrument.name);
  const RenderSetup setup = state_->setup(instrument, plan, sun, seed);
  const int width = setup.shape.pixels_per_group, column = sample / width * width;
  const Tile tile{line, 1, column, std::min(width, instrument.pixels - column)};
  TilePasses passes(setup, 1, tile.columns, state_->row_capacity(setup.shape),
                    state_->options.memory_bytes / kBudgetShares);
  const std::size_t layers = truth_layer_names(state_->scene).size(), bands = setup.shape.bands,
                    at = static_cast<std::size_t>(sample - column);
  std::vector<float> radiance(tile.pixels() * bands), truth(tile.pixels() * layers);
  std::vector<PixelTerms> terms(tile.pixels());
  passes.run(tile, {radiance.data(), truth.data(), layers, nullptr, terms.data()});
  PixelParts out;
  out.radiance.assign(radiance.data() + at * bands, radiance.data() + (at + 1) * bands);
  out.terms = std::move(terms[at]);
  return out;
}

void Renderer::probe_together(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                              std::uint64_t seed, const std::vector<Tile>& tiles, const ProbeSink& sink) {
  if (instrument.adaptive() || instrument.small_objects == scene::SmallObjects::on || instrument.replicates > 1) {
    probe(instrument, plan, sun, seed, tiles, sink);
    return;
  }
  const base::Doing doing("rendering tiles of instrument", instrument.name);
  const TilesTogether together(*state_, instrument, plan, sun, seed, tiles);
  TilePasses passes = together.passes();
  const std::size_t layers = truth_layer_names(state_->scene).size(), width = together.width();
  together.each_lot([&](const TileRays& rays, std::size_t first, std::size_t end) {
    PixelProbe lot;
    lot.tile = {0, static_cast<int>(rays.layout.lines), 0, static_cast<int>(rays.layout.columns)};
    lot.radiance.resize(rays.pixels() * plan.columns());
    lot.truth.resize(rays.pixels() * layers);
    passes.run_listed(rays, {lot.radiance.data(), lot.truth.data(), layers, nullptr}, &lot);
    std::size_t group = 0;
    for (std::size_t i = first; i < end; ++i) {
      sink(part_of(lot, tiles[i], group, width));
      group += groups_of(tiles[i], width);
    }
  });
}

std::vector<std::vector<float>> Renderer::draws_of(const scene::Instrument& instrument, const plan::Plan& plan,
                                                   const scene::Sun& sun, const std::vector<PixelDraw>& draws,
                                                   const std::vector<Tile>& tiles, const ProgressSink& progress) {
  const base::Doing doing("rendering tiles of instrument", instrument.name);
  const TilesTogether together(*state_, instrument, plan, sun, 0, tiles);
  TilePasses passes = together.passes();
  const std::size_t layers = truth_layer_names(state_->scene).size(), width = together.width(), bands = plan.columns();
  std::vector<std::vector<float>> out(draws.size());
  std::vector<float> radiance, truth;
  together.each_lot([&](const TileRays& rays, std::size_t first, std::size_t end) {
    radiance.resize(rays.pixels() * bands), truth.resize(rays.pixels() * layers);
    for (std::size_t d = 0; d < draws.size(); ++d) {
      base::throw_if_interrupted();
      passes.set_draw(draws[d]);
      passes.run_listed(rays, {radiance.data(), truth.data(), layers, nullptr}, nullptr);
      std::size_t group = 0;
      for (std::size_t i = first; i < end; ++i) group = append_pixels(radiance, bands, tiles[i], group, width, out[d]);
    }
    if (progress) progress(end, tiles.size());
  });
  return out;
}

void Renderer::probe_hits(const scene::Instrument& instrument, std::uint64_t seed, const std::vector<Tile>& tiles,
                          const HitSink& sink) {
  const plan::Plan dark = [] {
    plan::Plan plan;
    plan.sun_up = false;
    plan.sky_components = 0;
    return plan;
  }();
  const StageShape shape = make_stage_shape(instrument, dark, sensors::pixels_per_group(instrument));
  std::size_t pixels = 1, groups = 1;
  for (const auto& tile : tiles) {
    const TileLayout layout{static_cast<std::uint32_t>(tile.columns), static_cast<std::uint32_t>(tile.lines),
                            static_cast<std::uint32_t>(shape.pixels_per_group)};
    pixels = std::max(pixels, tile.pixels());
    groups = std::max(groups, layout.groups());
  }
  TraceStages stages(state_->context, state_->scene, state_->buffers, dark, shape, seed);
  TraceBuffers traced(state_->context, shape, pixels, groups);
  for (const auto& tile : tiles) {
    base::throw_if_interrupted();
    HitProbe probe;
    probe.tile = tile;
    TileRays rays = tile_rays(instrument, state_->scene, tile, shape.pixels_per_group);
    traced.groups.write(rays.groups);
    probe.groups = std::move(rays.groups);
    for (int chunk = 0; chunk < shape.chunks; ++chunk) {
      stages.run_primary(rays.layout, chunk, traced);
      collect_hits(shape, chunk, traced, probe);
    }
    sink(probe);
  }
}

}  // namespace raycube::render
