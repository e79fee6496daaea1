#include "host/render/tile_passes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host/base/interrupt.h"
#include "host/render/adaptive.h"
#include "host/render/picked_tiles.h"
#include "host/render/replicates.h"
#include "host/render/standard_error.h"
#include "host/render/truth.h"
#include "host/sensors/ray_groups.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

namespace {

/// Pixels of the image that tell its bands' means, to a few per cent.
constexpr std::uint64_t kScalePixels = 1024;

std::unique_ptr<scene::Instrument> with_first_samples(const scene::Instrument& instrument) {
  auto coarse = std::make_unique<scene::Instrument>(instrument);
  coarse->sampler = scene::SamplerKind::lattice;
  coarse->samples_u = instrument.first_samples, coarse->samples_v = 1;
  return coarse;
}

StageShape shape_of(const scene::Instrument& instrument, const plan::Plan& plan) {
  return make_stage_shape(instrument, plan, sensors::pixels_per_group(instrument));
}

std::size_t groups_across(int columns, int width) {
  return shared::rc_groups_per_line(static_cast<std::uint32_t>(columns), static_cast<std::uint32_t>(width));
}

/// What a baked table of the plan's rows may take where small objects get the rest for their own tiles: they
/// are few.
constexpr std::size_t kFineShare = 8;
constexpr std::size_t kMostFineGroups = 64;  ///< rendered at once

std::size_t fine_capacity(const StageShape& shape, std::size_t row_capacity) {
  return shape.chunked() ? std::max(row_capacity, kChunkedCapacity) : row_capacity;
}

/// What a group of pixels takes on the device.
std::size_t fine_group_bytes(const StageShape& shape, std::size_t capacity, bool errors) {
  const std::size_t parts = errors && shape.chunked() ? sensors::kSampleSubsets : 0;
  return static_cast<std::size_t>(shape.pixels_per_group) *
         (shape.pixel_bytes() + (1 + parts) * shape.row_bytes(capacity));
}

/// The instrument's small objects, or nothing where it does not ask for them or the scene has none.
std::optional<sensors::SmallObjectPixels> small_objects_of(const RenderSetup& setup) {
  if (setup.instrument.small_objects != scene::SmallObjects::on) return {};
  sensors::SmallObjectPixels small(setup.objects, setup.instrument);
  if (small.empty()) return {};
  return small;
}

/// Whether first samples tell which pixels need more: a look without paths does not see what lies behind plates.
bool looks_first(const RenderSetup& setup) {
  return setup.instrument.adaptive() && !(setup.shape.bounces && setup.shape.matter.plates);
}

}  // namespace

void add_counts(RenderStatistics& sum, const RenderStatistics& part) {
  for (const auto& [stage, seconds] : part.stage_s) sum.stage_s[stage] += seconds;
  sum.primary_rays += part.primary_rays, sum.sun_rays += part.sun_rays, sum.sky_rays += part.sky_rays;
  sum.paths += part.paths;
  sum.band_samples += part.band_samples;
  sum.overflow_pixels += part.overflow_pixels, sum.per_sample_pixels += part.per_sample_pixels;
}

/// Groups of one count of samples, a few at a time.
struct TilePasses::Fine {
  Fine(std::unique_ptr<scene::Instrument> instrument_, const RenderSetup& setup, BandTable& table, std::size_t groups_,
       std::size_t capacity, bool errors)
      : instrument(std::move(instrument_)),
        groups(groups_),
        worker(setup, table, groups_ * static_cast<std::size_t>(setup.shape.pixels_per_group),
               static_cast<int>(groups_), capacity, errors) {}
  std::unique_ptr<scene::Instrument> instrument;  ///< the worker's
  std::size_t groups;                             ///< at once
  TileWorker worker;
};

TilePasses::~TilePasses() = default;

LeastMemory least_memory(const scene::CompiledScene& scene, const scene::Instrument& instrument, const plan::Plan& plan,
                         std::size_t row_capacity) {
  const std::size_t cubes = instrument.standard_error == scene::StandardError::bands ? 2 : 1, values = plan.columns();
  LeastMemory out;
  const std::size_t layers = truth_layer_names(scene, instrument).size();
  out.strip_values = cubes * values + layers;
  if (instrument.first_opaque) out.strip_values += 2 * scene::named_count(scene);  // sums are doubles
  if (instrument.replicates > 1) out.strip_values += 4 * values + 2 * layers;      // sums are doubles
  out.table_rows = std::min(kFewestRows, most_rows(plan)) + plan.skeleton_rows();
  std::size_t& bytes = out.more_bytes;
  const auto add_parts = [&](const StageShape& shape) {
    if (shape.chunked()) bytes += sensors::kSampleSubsets * shape.row_bytes(row_capacity);
  };
  if (instrument.standard_error != scene::StandardError::off) add_parts(shape_of(instrument, plan));
  if (instrument.adaptive()) {
    const StageShape coarse = shape_of(*with_first_samples(instrument), plan);
    for (int of = 0; of < 2; ++of) {  // the look and the pixels it settles
      add_parts(coarse);
      bytes += coarse.pixel_bytes() + coarse.row_bytes(row_capacity);
    }
  }
  if (instrument.small_objects == scene::SmallObjects::on)  // one group at a time of every level
    for (const int samples : sensors::kFineLevels) {
      if (samples > sensors::finest_level(instrument)) break;
      const StageShape shape = shape_of(sensors::with_fine_samples(instrument, samples), plan);
      out.fine_bytes += fine_group_bytes(shape, fine_capacity(shape, row_capacity),
                                         instrument.standard_error != scene::StandardError::off);
    }
  return out;
}

TilePasses::TilePasses(const RenderSetup& setup, int lines, int columns, std::size_t row_capacity,
                       std::size_t table_bytes)
    : setup_(setup),
      layers_(truth::abundance + share_layers(setup.scene, setup.instrument)),
      small_(small_objects_of(setup)),
      fine_bytes_(small_ ? table_bytes / kFineShare : 0),
      table_(setup.context, setup.scene, setup.plan, setup.shape, table_bytes - fine_bytes_),
      coarse_instrument_(looks_first(setup) ? with_first_samples(setup.instrument) : nullptr),
      full_(setup, table_,
            static_cast<std::size_t>(lines) * groups_across(columns, setup.shape.pixels_per_group) *
                setup.shape.pixels_per_group,
            lines, row_capacity, setup.instrument.standard_error != scene::StandardError::off),
      most_groups_(static_cast<std::size_t>(lines) * groups_across(columns, setup.shape.pixels_per_group)),
      row_capacity_(row_capacity) {
  if (!coarse_instrument_) return;
  const std::size_t groups =
      static_cast<std::size_t>(lines + 2) * (groups_across(columns, setup.shape.pixels_per_group) + 2);
  RenderSetup coarse{setup.context, setup.scene,         setup.objects,
                     setup.buffers, *coarse_instrument_, setup.plan,
                     setup.sun,     setup.seed,          shape_of(*coarse_instrument_, setup.plan)};
  coarse_.emplace(coarse, table_, most_groups_ * setup.shape.pixels_per_group, lines, row_capacity,
                  setup.instrument.standard_error != scene::StandardError::off);
  coarse.shape.sky_shadows = false, coarse.shape.bounces = false, coarse.shape.first_opaque = false;
  look_.emplace(coarse, table_, groups * setup.shape.pixels_per_group, 1, row_capacity, true);
}

std::vector<shared::RayGroup> TilePasses::groups_of(int first_line, int lines, int first_group, int groups) const {
  const auto all = sensors::make_ray_groups(setup_.instrument, setup_.scene, first_line, lines);
  const int per_line = sensors::groups_per_line(setup_.instrument);
  std::vector<shared::RayGroup> out;
  for (int line = 0; line < lines; ++line)
    out.insert(out.end(), all.begin() + line * per_line + first_group,
               all.begin() + line * per_line + first_group + groups);
  return out;
}

const std::vector<float>& TilePasses::scale() {
  if (!scale_.empty()) return scale_;
  const int width = setup_.shape.pixels_per_group;
  std::vector<shared::RayGroup> groups;
  std::vector<int> used;  // pixels of each group that lie in the image
  double pixels = 0;
  for (const Tile& tile : pick_tiles(setup_.instrument, setup_.seed, kScalePixels)) {
    const auto rays = tile_rays(setup_.instrument, setup_.scene, tile, width);
    groups.insert(groups.end(), rays.groups.begin(), rays.groups.end());
    for (int line = 0; line < tile.lines; ++line)
      for (int column = 0; column < tile.columns; column += width)
        used.push_back(std::min(width, tile.columns - column)), pixels += used.back();
  }
  const std::size_t bands = setup_.shape.bands;
  std::vector<double> mean(bands);
  std::vector<float> radiance(most_groups_ * width * bands), truth(most_groups_ * width * layers_);
  for (std::size_t first = 0; first < groups.size(); first += most_groups_) {
    const std::size_t end = std::min(first + most_groups_, groups.size());
    const TileRays rays = listed_rays(
        {groups.begin() + static_cast<std::ptrdiff_t>(first), groups.begin() + static_cast<std::ptrdiff_t>(end)},
        width);
    (coarse_ ? *coarse_ : full_).run(rays, {radiance.data(), truth.data(), layers_, nullptr});
    for (std::size_t p = 0; p < rays.pixels(); ++p) {
      const auto wide = static_cast<std::size_t>(width);
      if (p % wide >= static_cast<std::size_t>(used[first + p / wide])) continue;
      for (std::size_t b = 0; b < bands; ++b) mean[b] += double{radiance[p * bands + b]} / pixels;
    }
  }
  mean.resize(setup_.plan.bands.size());  // truth is judged by nobody
  scale_ = error_scale(mean);
  return scale_;
}

void TilePasses::run_pass(TileWorker& worker, const TileRays& rays, const TileOutput& out, PixelProbe* probe) {
  const std::size_t bands = setup_.shape.bands;
  const bool layers = setup_.instrument.standard_error != scene::StandardError::off && out.layers > layers_;
  std::vector<float> own(layers && !out.band_error ? rays.pixels() * bands : 0);
  TileOutput here = out;
  if (!own.empty()) here.band_error = own.data();
  worker.run(rays, here, probe);
  for (std::size_t p = 0; layers && p < rays.pixels(); ++p)
    out.truth[p * out.layers + layers_] = worst_error(here.band_error + p * bands, scale_);
}

void TilePasses::run_groups(TileWorker& worker, const Tile& tile, const std::vector<shared::RayGroup>& groups,
                            const std::vector<std::size_t>& first_pixel, const TileOutput& out) {
  if (groups.empty()) return;
  base::throw_if_interrupted();
  const std::size_t bands = setup_.shape.bands, columns = static_cast<std::size_t>(tile.columns),
                    width = static_cast<std::size_t>(setup_.shape.pixels_per_group);
  const TileRays rays = listed_rays(groups, setup_.shape.pixels_per_group);
  std::vector<float> radiance(rays.pixels() * bands), truth(rays.pixels() * out.layers),
      error(out.band_error ? rays.pixels() * bands : 0);
  std::vector<PixelTerms> terms(out.terms ? rays.pixels() : 0);
  run_pass(worker, rays,
           {radiance.data(), truth.data(), out.layers, out.band_error ? error.data() : nullptr,
            out.terms ? terms.data() : nullptr},
           nullptr);
  for (std::size_t g = 0; g < first_pixel.size(); ++g) {
    const std::size_t from = g * width, to = first_pixel[g], used = std::min(width, columns - to % columns);
    std::copy_n(radiance.data() + from * bands, used * bands, out.radiance + to * bands);
    std::copy_n(truth.data() + from * out.layers, used * out.layers, out.truth + to * out.layers);
    if (out.band_error) std::copy_n(error.data() + from * bands, used * bands, out.band_error + to * bands);
    if (out.terms) std::move(terms.data() + from, terms.data() + from + used, out.terms + to);
  }
}

void TilePasses::run_adaptive(const Tile& tile, const TileOutput& out) {
  const int width = setup_.shape.pixels_per_group;
  const std::size_t bands = setup_.shape.bands, wide = static_cast<std::size_t>(width);
  // The look reaches one line and one group beyond the tile where the image does.
  const int first_line = std::max(0, tile.first_line - 1),
            end_line = std::min(setup_.instrument.lines, tile.first_line + tile.lines + 1);
  const int tile_group = tile.first_column / width, tile_groups = static_cast<int>(groups_across(tile.columns, width));
  const int first_group = std::max(0, tile_group - 1),
            end_group = std::min(sensors::groups_per_line(setup_.instrument), tile_group + tile_groups + 1);
  const TileRays look =
      listed_rays(groups_of(first_line, end_line - first_line, first_group, end_group - first_group), width);

  FirstLook seen;
  seen.lines = end_line - first_line, seen.columns = (end_group - first_group) * width;
  seen.layers = layers_;
  seen.truth.resize(look.pixels() * layers_);
  std::vector<float> radiance(look.pixels() * bands), error(look.pixels() * bands);
  look_->run(look, {radiance.data(), seen.truth.data(), layers_, error.data()});
  for (std::size_t p = 0; p < look.pixels(); ++p) seen.error.push_back(worst_error(error.data() + p * bands, scale_));
  const std::vector<std::uint8_t> open = unsettled(seen, setup_.plan.tolerance);

  std::vector<shared::RayGroup> groups[2];  // settled, and those that need all samples
  std::vector<std::size_t> first_pixel[2];  // of each, in the tile
  for (int line = 0; line < tile.lines; ++line)
    for (int group = 0; group < tile_groups; ++group) {
      const int row = tile.first_line + line - first_line, column = (tile_group + group - first_group) * width;
      const std::size_t from =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(seen.columns) + static_cast<std::size_t>(column);
      const std::size_t used = std::min(wide, static_cast<std::size_t>(tile.columns - group * width));
      const auto first = open.begin() + static_cast<std::ptrdiff_t>(from);
      const bool all =
          std::any_of(first, first + static_cast<std::ptrdiff_t>(used), [](auto flag) { return flag != 0; }) ||
          (small_ && small_->needs_all(look.groups[from / wide], static_cast<int>(used)));
      groups[all].push_back(look.groups[from / wide]);
      first_pixel[all].push_back(static_cast<std::size_t>(line) * static_cast<std::size_t>(tile.columns) +
                                 static_cast<std::size_t>(group * width));
      adaptive_pixels_ += used;
      if (all) refined_pixels_ += used;
    }
  run_groups(*coarse_, tile, groups[0], first_pixel[0], out);
  run_groups(full_, tile, groups[1], first_pixel[1], out);
}

TilePasses::Fine& TilePasses::fine(int samples) {
  std::unique_ptr<Fine>& at = fine_[samples];
  if (at) return *at;
  auto instrument = std::make_unique<scene::Instrument>(sensors::with_fine_samples(setup_.instrument, samples));
  RenderSetup setup{setup_.context, setup_.scene, setup_.objects,
                    setup_.buffers, *instrument,  setup_.plan,
                    setup_.sun,     setup_.seed,  shape_of(*instrument, setup_.plan)};
  const bool errors = setup_.instrument.standard_error != scene::StandardError::off;
  const std::size_t capacity = fine_capacity(setup.shape, row_capacity_);
  const std::size_t group_bytes = fine_group_bytes(setup.shape, capacity, errors);
  const std::size_t groups = std::clamp<std::size_t>(fine_bytes_ / std::size(sensors::kFineLevels) / group_bytes, 1,
                                                     std::min(kMostFineGroups, most_groups_));
  at = std::make_unique<Fine>(std::move(instrument), setup, table_, groups, capacity, errors);
  return *at;
}

void TilePasses::run_small_objects(const Tile& tile, const TileOutput& out) {
  if (!small_) return;
  const int width = setup_.shape.pixels_per_group, across = static_cast<int>(groups_across(tile.columns, width));
  const TileRays rays = tile_rays(setup_.instrument, setup_.scene, tile, width);
  struct Lot {
    std::vector<shared::RayGroup> groups;
    std::vector<std::size_t> first_pixel;
  };
  std::map<int, Lot> lots;  // by samples
  for (int line = 0; line < tile.lines; ++line)
    for (int group = 0; group < across; ++group) {
      const auto& here = rays.groups[static_cast<std::size_t>(line * across + group)];
      // A tile that ends inside the image ends with a whole group.
      const int used = std::min(width, tile.columns - group * width), samples = small_->samples_of(here, used);
      if (samples == 0) continue;
      lots[samples].groups.push_back(here);
      lots[samples].first_pixel.push_back(static_cast<std::size_t>(line) * static_cast<std::size_t>(tile.columns) +
                                          static_cast<std::size_t>(group * width));
      fine_pixels_[samples] += static_cast<std::uint64_t>(used);
    }
  for (auto& [samples, lot] : lots) {
    Fine& here = fine(samples);
    for (std::size_t first = 0; first < lot.groups.size(); first += here.groups) {
      const auto from = static_cast<std::ptrdiff_t>(first),
                 to = static_cast<std::ptrdiff_t>(std::min(first + here.groups, lot.groups.size()));
      run_groups(here.worker, tile, {lot.groups.begin() + from, lot.groups.begin() + to},
                 {lot.first_pixel.begin() + from, lot.first_pixel.begin() + to}, out);
    }
  }
}

void TilePasses::run_replicate(int replicate, const Tile& tile, const TileOutput& out) {
  full_.set_draw({replicate_seed(setup_.seed, replicate)});
  full_.run(tile_rays(setup_.instrument, setup_.scene, tile, setup_.shape.pixels_per_group), out);
}

void TilePasses::run_replicates(const Tile& tile, const TileOutput& out) {
  const std::size_t pixels = tile.pixels();
  const std::size_t shares = std::min(share_layers(setup_.scene, setup_.instrument), out.layers - truth::abundance);
  ReplicateSums sums(pixels, setup_.shape.bands, scene::named_count(setup_.scene), shares);
  std::vector<PixelTerms> terms(out.terms ? pixels : 0);
  for (int replicate = 0; replicate < setup_.instrument.replicates; ++replicate) {
    base::throw_if_interrupted();
    run_replicate(replicate, tile, out);
    for (std::size_t p = 0; p < terms.size(); ++p)
      for (const Term& term : out.terms[p])
        terms[p].push_back({term.key, term.channel, term.weight / setup_.instrument.replicates});
    sums.add(0, pixels, out.radiance, out.truth, out.layers);
    sums.next();
  }
  std::move(terms.begin(), terms.end(), out.terms);
  spread_.add(sums.spread(setup_.plan.bands.size()));
  sums.mean(0, pixels, out.radiance, out.truth, out.layers);
}

void TilePasses::run(const Tile& tile, TileOutput out, PixelProbe* probe) {
  const bool layers = setup_.instrument.standard_error != scene::StandardError::off && out.layers > layers_;
  if (coarse_ || layers) scale();
  if (coarse_)
    run_adaptive(tile, out);
  else if (setup_.instrument.replicates > 1)
    run_replicates(tile, out);
  else
    run_pass(full_, tile_rays(setup_.instrument, setup_.scene, tile, setup_.shape.pixels_per_group), out, probe);
  run_small_objects(tile, out);
  for (std::size_t p = 0; layers && p < tile.pixels(); ++p) {
    float* at = out.truth + p * out.layers + layers_;
    at[1] = at[0] <= setup_.plan.tolerance ? 0.0f : 1.0f;  // an error that is not known has not converged
  }
}

void TilePasses::run_listed(const TileRays& rays, const TileOutput& out, PixelProbe* probe) {
  full_.run(rays, out, probe);
}

RenderStatistics TilePasses::statistics() const {
  RenderStatistics all = full_.statistics();
  const auto histogram = [&](double share) {
    std::uint64_t count = 0, below = 0;
    std::vector<std::uint64_t> terms = full_.term_histogram();
    for (std::size_t i = 0; coarse_ && i < terms.size(); ++i)
      terms[i] += coarse_->term_histogram()[i];  // a look's are not the image's
    for (const auto& [unused, fine] : fine_)
      for (std::size_t i = 0; i < terms.size(); ++i) terms[i] += fine->worker.term_histogram()[i];
    for (const auto n : terms) count += n;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      below += terms[i];
      if (count && static_cast<double>(below) >= share * static_cast<double>(count))
        return static_cast<std::uint32_t>(i);
    }
    return 0u;
  };
  all.terms_p50 = histogram(0.5), all.terms_p95 = histogram(0.95);
  for (const auto& [unused, fine] : fine_) add_counts(all, fine->worker.statistics());
  all.small_object_pixels = fine_pixels_;
  all.spread = spread_;
  if (!coarse_) return all;
  add_counts(all, look_->statistics());
  add_counts(all, coarse_->statistics());
  all.adaptive_pixels = adaptive_pixels_, all.refined_pixels = refined_pixels_;
  return all;
}

}  // namespace raycube::render
