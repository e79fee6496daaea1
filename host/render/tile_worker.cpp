#include "host/render/tile_worker.h"

#include <algorithm>
#include <span>
#include <cmath>
#include <chrono>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>

#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/render/standard_error.h"
#include "host/render/truth.h"
#include "host/sensors/psf.h"
#include "host/sensors/ray_groups.h"
#include "kernels/atmosphere/nodes.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

namespace {

constexpr std::size_t kOverflowCapacities[] = {64, 256};
constexpr std::size_t kOverflowBatch = 256;  ///< flagged pixels relaunched at once
constexpr std::size_t kHistogramBins = 4096;

/// Sum number i of an item, with its compensation when sums are carried over chunks.
double total(const float* sums, std::size_t count, bool chunked, std::size_t i) {
  return chunked ? double{sums[i]} + sums[count + i] : double{sums[i]};
}

double weight_of(int i, int k, float f) { return i == k ? 1.0 - f : i == k + 1 ? double{f} : 0.0; }

}  // namespace

template <class Action>
void TileWorker::timed(const std::string& stage, Action action) {
  const base::Doing doing("stage", stage);
  const auto start = std::chrono::steady_clock::now();
  action();
  setup_.context.finish();
  statistics_.stage_s[stage] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

TileWorker::TileWorker(const RenderSetup& setup, BandTable& table, std::size_t pixels, int lines,
                       std::size_t row_capacity, bool errors)
    : setup_(setup),
      row_stages_(setup.context, setup.buffers, setup.plan, setup.shape, sensors::SampleWeights(setup.instrument)),
      trace_stages_(setup.context, setup.scene, setup.buffers, setup.plan, setup.shape, setup.seed,
                    sensors::SampleWeights(setup.instrument)),
      table_(table),
      traced_(setup.context, setup.shape, pixels,
              pixels / setup.shape.pixels_per_group + static_cast<std::size_t>(lines) + 1),
      rows_(setup.context, setup.shape, pixels, row_capacity),
      radiance_(setup.context, pixels * setup.shape.bands_padded, cl::Access::read_write, "radiance of a tile"),
      all_baked_(table_.capacity() > setup.plan.seen_curves.size() + setup.plan.environment.nodes()),
      named_(scene::named_materials(setup.scene)),
      term_histogram_(kHistogramBins, 0) {
  if (setup.shape.first_opaque)
    opaque_.emplace(setup.context, pixels * traced_.elements.near, cl::Access::read_write, "what is opaque");
  for (int subset = 0; errors && setup.shape.chunked() && subset < sensors::kSampleSubsets; ++subset)
    subset_rows_.emplace_back(setup.context, setup.shape, pixels, row_capacity);
  if (all_baked_) {
    std::vector<std::uint64_t> keys;  // others' curves need not cover the bands
    for (const auto curve : setup.plan.seen_curves) keys.push_back(rc_key_of(curve));
    timed("bake", [&] { table_.ensure(keys); });
  }
  statistics_.kernel_variants = trace_stages_.variants();
  statistics_.program_hash = program_hash(trace_stages_, row_stages_);
  statistics_.trace_program_hash = trace_stages_.program_hash();
}

std::array<double, 3> TileWorker::centre_direction(std::uint32_t pixel) const {
  const auto& g = groups_[layout_.group_of(pixel)];
  const double a = layout_.place_in_group(pixel);
  return {g.d0.x + a * g.du.x, g.d0.y + a * g.du.y, g.d0.z + a * g.du.z};
}

std::pair<int, float> TileWorker::view_nodes(std::uint32_t pixel) const {
  const plan::NodeAxis& view = setup_.plan.view;
  const auto d = centre_direction(pixel);
  std::pair<int, float> out;
  rc_node_weights(static_cast<float>(-std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / d[2]), view.first, view.step,
                  view.count, &out.first, &out.second);
  return out;
}

std::size_t TileWorker::material_of_key(std::uint64_t key) const {
  return named_[scene::material_of_curve(setup_.scene, rc_key_curve(key, 0))];
}

void TileWorker::write_truth(std::uint32_t pixel, const float* sums, const float* abundance, const TileOutput& out) {
  fill_truth({sums, abundance, centre_direction(pixel)}, scene::named_count(setup_.scene), setup_.sun,
             out.truth + pixel * out.layers);
}

void collect_hits(const StageShape& shape, int chunk, const TraceBuffers& traced, HitProbe& probe) {
  const auto hits = traced.hits.read_all();
  const std::size_t pixels = probe.tile.pixels(), samples = static_cast<std::size_t>(shape.samples);
  const std::size_t first = std::size_t(chunk) * shape.chunk_samples,
                    end = std::min(first + shape.chunk_samples, samples);
  probe.samples = shape.samples;
  probe.hit_instance.resize(pixels * samples);
  probe.hit_primitive.resize(pixels * samples);
  for (std::size_t p = 0; p < pixels; ++p)
    for (std::size_t s = first; s < end; ++s) {
      const std::uint32_t* of_pixel = hits.data() + p * traced.elements.hits;
      const auto plane = [&](std::size_t number) { return of_pixel[shared::TileElements::hits_at(number, s - first)]; };
      probe.hit_instance[p * samples + s] = plane(RC_HIT_INSTANCE);
      probe.hit_primitive[p * samples + s] = plane(RC_HIT_PRIMITIVE);
    }
}

void TileWorker::collect(int chunk, PixelProbe& probe) const {
  const StageShape& shape = setup_.shape;
  collect_hits(shape, chunk, traced_, probe);
  const auto sun = traced_.sun.read_all();
  const auto met = traced_.met_sky.read_all();
  const std::size_t pixels = probe.tile.pixels(), samples = static_cast<std::size_t>(shape.samples);
  const std::size_t first = std::size_t(chunk) * shape.chunk_samples,
                    end = std::min(first + shape.chunk_samples, samples);
  const auto planes = static_cast<std::size_t>(shape.sky_planes()),
             sides = static_cast<std::size_t>(shape.matter.sides());
  probe.sides = shape.matter.sides();
  probe.sun_visible.resize(pixels * sides * samples);
  probe.sky_met.resize(pixels * sides * samples * planes);
  for (std::size_t p = 0; p < pixels; ++p)
    for (std::size_t side = 0; side < sides; ++side)
      for (std::size_t s = first; s < end; ++s) {
        const std::size_t slot = side * traced_.elements.near + s - first, to = (p * sides + side) * samples + s;
        probe.sun_visible[to] = (sun[p * traced_.elements.sun + slot / RC_WORD] >> (slot % RC_WORD)) & 1u;
        for (int m = 0; m < shape.components + shape.lamps; ++m)
          probe.sky_met[planes * to + m] =
              met[p * traced_.elements.met_sky + traced_.elements.met_sky_at(static_cast<std::size_t>(m), slot)];
      }
  if (shape.path_steps > 0 && chunk + 1 == shape.chunks) collect_paths(probe);
}

void TileWorker::collect_paths(PixelProbe& probe) const {
  const StageShape& shape = setup_.shape;
  const std::size_t pixels = probe.tile.pixels(), lines = static_cast<std::size_t>(shape.skeleton),
                    width = traced_.elements.glow / RC_PATH_PARTS;
  probe.steps.resize(pixels * shape.path_steps);
  traced_.path_log.read(std::span(probe.steps), 0);
  const auto glow = traced_.glow.read_all();
  probe.glow.assign(pixels * lines, 0.0);
  for (std::size_t p = 0; p < pixels; ++p)
    for (std::size_t part = 0; part < RC_PATH_PARTS; ++part)
      for (std::size_t m = 0; m < lines; ++m)
        probe.glow[p * lines + m] += static_cast<double>(glow[p * traced_.elements.glow + part * width + m]);
}

void TileWorker::run(const TileRays& tile, const TileOutput& out, PixelProbe* probe) {
  const StageShape& shape = setup_.shape;
  const std::uint32_t pixels = static_cast<std::uint32_t>(tile.pixels());
  layout_ = tile.layout;
  timed("rays", [&] {
    groups_ = tile.groups;
    traced_.groups.write(groups_);
  });

  if (probe) probe->groups = groups_;
  std::vector<double> opaque(fills_opaque(out) ? pixels * scene::named_count(setup_.scene) : 0);
  for (int chunk = 0; chunk < shape.chunks; ++chunk) {
    trace_stages_.run(layout_, chunk, traced_, statistics_.stage_s);
    timed("shade", [&] {
      row_stages_.shade({pixels, nullptr}, layout_, traced_, chunk, sensors::kAllSamples, chunk == 0, rows_);
      if (out.band_error)
        for (int subset = 0; subset < static_cast<int>(subset_rows_.size()); ++subset)
          row_stages_.shade({pixels, nullptr}, layout_, traced_, chunk, subset, chunk == 0, subset_rows_[subset]);
    });
    if (probe) collect(chunk, *probe);
    if (!opaque.empty() && shape.first_opaque) timed("first opaque", [&] { add_first_opaque(chunk, opaque); });
  }
  std::vector<std::uint32_t> all_pixels(pixels);
  std::iota(all_pixels.begin(), all_pixels.end(), 0u);
  host_radiance_.clear();
  const std::vector<std::uint32_t> flagged = finish_all(rows_, all_pixels, sensors::kAllSamples, out);
  if (!flagged.empty()) sum_per_sample(flagged, out);
  statistics_.per_sample_pixels += flagged.size();

  timed("read", [&] {
    const auto mapped = radiance_.map(false);
    const std::size_t bands = shape.bands;
    for (std::uint32_t p = 0; p < pixels; ++p)
      std::memcpy(out.radiance + p * bands, mapped.data() + p * std::size_t(shape.bands_padded), bands * sizeof(float));
    radiance_.unmap(mapped);
    for (const auto& [pixel, values] : host_radiance_)
      std::transform(values.begin(), values.end(), out.radiance + pixel * bands,
                     [](double v) { return static_cast<float>(v); });
  });
  if (!opaque.empty()) write_first_opaque(opaque, out);
  if (out.band_error) add_errors(all_pixels, out);
  double hit = 0;
  for (std::uint32_t p = 0; p < pixels; ++p) hit += out.truth[p * out.layers + truth::hit_fraction];
  const double rays = static_cast<double>(pixels) * shape.samples;
  statistics_.primary_rays += static_cast<std::uint64_t>(rays);
  const double hit_rays = hit / std::max(1u, pixels) * rays;
  if (setup_.plan.sun_up) statistics_.sun_rays += static_cast<std::uint64_t>(hit_rays);
  if (shape.sky_shadows && setup_.plan.components() > 0)
    statistics_.sky_rays += static_cast<std::uint64_t>(hit * setup_.plan.sky.rays);
  statistics_.paths += static_cast<std::uint64_t>(hit * setup_.plan.paths());
  statistics_.band_samples += static_cast<std::uint64_t>(pixels) * setup_.plan.bands.size();
}

std::vector<std::uint32_t> TileWorker::finish_all(RowBuffers& rows, const std::vector<std::uint32_t>& pixels,
                                                  int subset, const TileOutput& out) {
  std::vector<std::uint32_t> flagged = finish_rows(rows, pixels, false, out);
  if (out.truth) statistics_.overflow_pixels += flagged.size();
  if (!setup_.shape.chunked())
    for (const std::size_t capacity : kOverflowCapacities)
      if (!flagged.empty() && capacity > rows.capacity) flagged = relaunch(flagged, capacity, subset, out);
  return flagged;
}

void TileWorker::add_errors(const std::vector<std::uint32_t>& pixels, const TileOutput& out) {
  const StageShape& shape = setup_.shape;
  const std::size_t bands = shape.bands, values = pixels.size() * bands;
  if (shape.samples < sensors::kSampleSubsets) {
    std::fill_n(out.band_error, values, std::numeric_limits<float>::quiet_NaN());
    return;
  }
  std::fill_n(out.band_error, values, 0.0f);
  for (int subset = 0; subset < sensors::kSampleSubsets; ++subset) {
    RowBuffers& rows = shape.chunked() ? subset_rows_[subset] : rows_;
    if (!shape.chunked())
      timed("shade", [&] {
        row_stages_.shade({static_cast<std::uint32_t>(pixels.size()), nullptr}, layout_, traced_, 0, subset, true,
                          rows);
      });
    const std::vector<std::uint32_t> unknown = finish_all(rows, pixels, subset, {});
    timed("standard error", [&] {
      const auto mapped = radiance_.map(false);
      for (std::size_t p = 0; p < pixels.size(); ++p) {
        const float *part = mapped.data() + p * std::size_t(shape.bands_padded), *whole = out.radiance + p * bands;
        float* sum = out.band_error + p * bands;
        for (std::size_t b = 0; b < bands; ++b) sum[b] += (part[b] - whole[b]) * (part[b] - whole[b]);
      }
      radiance_.unmap(mapped);
      for (const std::uint32_t pixel : unknown)
        std::fill_n(out.band_error + pixel * bands, bands, std::numeric_limits<float>::quiet_NaN());
    });
  }
  const float factor = static_cast<float>(error_of_spread(setup_.instrument.sampler));
  for (std::size_t i = 0; i < values; ++i) out.band_error[i] = factor * std::sqrt(out.band_error[i]);
}

std::vector<std::uint32_t> TileWorker::finish_rows(RowBuffers& rows, const std::vector<std::uint32_t>& pixels,
                                                   bool use_list, const TileOutput& out) {
  const StageShape& shape = setup_.shape;
  const std::size_t items = pixels.size();
  const std::size_t materials = scene::named_count(setup_.scene);
  std::optional<cl::Buffer<std::uint32_t>> list;
  if (use_list) list.emplace(setup_.context, pixels, cl::Access::read_only, "list of pixels");
  const PixelSelection selection{static_cast<std::uint32_t>(items), list ? &*list : nullptr};
  std::vector<std::uint32_t> flagged;
  std::vector<std::array<plan::EnvironmentWeight, 4>> around(shape.environment ? items : 0);
  std::vector<std::size_t> range_ends;  // items whose keys fit the band table together
  std::vector<std::vector<std::uint64_t>> range_keys;
  timed("collect", [&] {
    const auto count = rows.count.map(false);
    const auto keys = rows.keys.map(false);
    const auto sums = rows.sums.map(false);
    const auto truth = rows.truth.map(false);
    std::set<std::uint64_t> used;
    std::vector<float> abundance(materials);
    float truth_sums[RC_TRUTH_SUMS];
    for (std::size_t i = 0; i < items; ++i) {
      if (count[i] == RC_ROW_OVERFLOW) {
        flagged.push_back(pixels[i]);
        continue;
      }
      std::fill(abundance.begin(), abundance.end(), 0.0f);
      for (std::size_t t = 0; t < RC_TRUTH_SUMS; ++t)
        truth_sums[t] =
            static_cast<float>(total(truth.data() + i * rows.elements.truth, RC_TRUTH_SUMS, shape.chunked(), t));
      const std::uint64_t* row_keys = keys.data() + i * rows.elements.keys;
      std::set<std::uint64_t> wanted;
      if (shape.environment) {
        around[i] = environment_of(pixels[i], truth_sums);
        for (const auto& node : around[i])
          if (node.weight > 0) wanted.insert(plan::kEnvironmentKey | node.node);
      }
      if (!all_baked_) wanted.insert(row_keys, row_keys + count[i]);  // else rows of the environment alone come up anew
      const auto anew = static_cast<std::size_t>(
          std::count_if(wanted.begin(), wanted.end(), [&](auto key) { return used.count(key) == 0; }));
      if (used.size() + anew + 1 > table_.capacity() && !used.empty()) {
        range_ends.push_back(i);
        range_keys.emplace_back(used.begin(), used.end());
        used.clear();
      }
      used.merge(wanted);
      for (std::uint32_t k = 0; k < count[i]; ++k) {
        const float* row = sums.data() + i * rows.elements.sums + k * rows.elements.sums_of_key;
        const std::size_t last = shape.accumulators() - 1;
        abundance[material_of_key(row_keys[k])] +=
            static_cast<float>(total(row, shape.accumulators(), shape.chunked(), last));
      }
      if (out.truth) write_truth(pixels[i], truth_sums, abundance.data(), out);
    }
    rows.count.unmap(count);
    rows.keys.unmap(keys);
    rows.sums.unmap(sums);
    rows.truth.unmap(truth);
    range_ends.push_back(items);
    range_keys.emplace_back(used.begin(), used.end());
  });
  std::size_t first = 0;
  for (std::size_t r = 0; r < range_ends.size(); ++r) {
    const auto first_item = static_cast<std::uint32_t>(first),
               item_count = static_cast<std::uint32_t>(range_ends[r] - first);
    if (!all_baked_ || !range_keys[r].empty()) timed("bake", [&] { table_.ensure(range_keys[r]); });
    if (shape.environment && item_count) write_environment(std::span(around).subspan(first, item_count), first, rows);
    if (item_count) {
      timed("resolve", [&] { row_stages_.resolve(first_item, item_count, selection, layout_, traced_, table_, rows); });
      timed("integrate", [&] { row_stages_.integrate(first_item, item_count, selection, table_, rows, radiance_); });
      if (out.terms) file_terms(first, item_count, pixels, rows, out.terms);
    }
    first = range_ends[r];
  }
  if (!out.truth) return flagged;
  const auto terms = rows.term_count.map(false);
  for (std::size_t i = 0; i < items; ++i) ++term_histogram_[std::min<std::size_t>(terms[i], kHistogramBins - 1)];
  rows.term_count.unmap(terms);
  return flagged;
}

std::vector<std::uint32_t> TileWorker::relaunch(const std::vector<std::uint32_t>& flagged, std::size_t capacity,
                                                int subset, const TileOutput& out) {
  std::vector<std::uint32_t> still_flagged;
  RowBuffers rows(setup_.context, setup_.shape, std::min(flagged.size(), kOverflowBatch), capacity);
  for (std::size_t first = 0; first < flagged.size(); first += kOverflowBatch) {
    const std::vector<std::uint32_t> batch(flagged.begin() + first,
                                           flagged.begin() + std::min(first + kOverflowBatch, flagged.size()));
    cl::Buffer<std::uint32_t> list(setup_.context, batch, cl::Access::read_only, "list of pixels");
    timed("shade", [&] {
      row_stages_.shade({static_cast<std::uint32_t>(batch.size()), &list}, layout_, traced_, 0, subset, true, rows);
    });
    const auto more = finish_rows(rows, batch, true, out);
    still_flagged.insert(still_flagged.end(), more.begin(), more.end());
  }
  return still_flagged;
}

void TileWorker::sum_per_sample(const std::vector<std::uint32_t>& flagged, const TileOutput& out) {
  const StageShape& shape = setup_.shape;
  const plan::Plan& plan = setup_.plan;
  const std::size_t bands = shape.bands, materials = scene::named_count(setup_.scene);
  // Every sample deposits at most four keys for each side of its surface, so a chunk can never overflow this row.
  RowBuffers rows(setup_.context, shape, 1, 4 * static_cast<std::size_t>(shape.matter.sides() * shape.chunk_samples));
  struct Sum {
    std::vector<double> radiance, abundance, path;
    double truth[RC_TRUTH_SUMS] = {};
    PixelTerms terms;
  };
  std::vector<Sum> results(
      flagged.size(),
      {std::vector<double>(bands), std::vector<double>(materials), std::vector<double>(shape.heights), {}, {}});
  const std::vector<float> path_row = plan::bake_row(plan, setup_.scene, 0);
  for (int chunk = 0; chunk < shape.chunks; ++chunk) {
    if (shape.chunked()) trace_stages_.run(layout_, chunk, traced_, statistics_.stage_s);
    for (std::size_t f = 0; f < flagged.size(); ++f) {
      cl::Buffer<std::uint32_t> list(setup_.context, std::span(&flagged[f], 1), cl::Access::read_only, "one pixel");
      timed("shade", [&] { row_stages_.shade({1, &list}, layout_, traced_, chunk, sensors::kAllSamples, true, rows); });
      const auto d = centre_direction(flagged[f]);
      const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      const auto [iv, fv] = view_nodes(flagged[f]);
      int ix, iy;
      float fx, fy;
      rc_node_weights(static_cast<float>(-d[0] / length), plan.path_x.first, plan.path_x.step, plan.path_x.count, &ix,
                      &fx);
      rc_node_weights(static_cast<float>(-d[1] / length), plan.path_y.first, plan.path_y.step, plan.path_y.count, &iy,
                      &fy);
      const auto add = [&](std::uint64_t key, const std::vector<float>& baked, int channel, double weight) {
        if (weight == 0) return;
        if (out.terms) results[f].terms.push_back({key, static_cast<std::uint32_t>(channel), weight});
        const float* e = baked.data() + static_cast<std::size_t>(channel) * shape.bands_padded;
        for (std::size_t b = 0; b < bands; ++b) results[f].radiance[b] += weight * e[b];
      };
      timed("per sample", [&] {
        const auto path = rows.path.read_all();
        for (int h = 0; h < shape.heights; ++h)
          results[f].path[h] += total(path.data(), shape.heights, shape.chunked(), h);
        for (int h = 0; h < shape.heights; ++h)
          for (int y = 0; y < shape.path_y; ++y)
            for (int x = 0; x < shape.path_x; ++x)
              add(0, path_row, (h * shape.path_y + y) * shape.path_x + x,
                  total(path.data(), shape.heights, shape.chunked(), h) * weight_of(x, ix, fx) * weight_of(y, iy, fy));
        const auto truth = rows.truth.read_all();
        for (std::size_t t = 0; t < RC_TRUTH_SUMS; ++t)
          results[f].truth[t] += total(truth.data(), RC_TRUTH_SUMS, shape.chunked(), t);
        const std::uint32_t count = rows.count.read_all().at(0);
        if (count > rows.capacity)
          throw base::Error(base::Fault::bug, "a pixel's row by sample holds " + std::to_string(rows.capacity) +
                                                  " keys, too few for its samples");
        const auto keys = rows.keys.read_all();
        const auto sums = rows.sums.read_all();
        for (std::uint32_t k = 0; k < count; ++k) {
          const float* row = sums.data() + k * rows.elements.sums_of_key;
          const auto baked = plan::bake_row(plan, setup_.scene, keys[k]);
          for (int i = 0; i < shape.accumulators() - 1; ++i)
            for (int v = 0; v < shape.views; ++v)
              add(keys[k], baked, i * shape.views + v,
                  total(row, shape.accumulators(), shape.chunked(), i) * weight_of(v, iv, fv));
          const double covers = total(row, shape.accumulators(), shape.chunked(), shape.accumulators() - 1);
          if (shape.covers) add(keys[k], baked, plan.coverage_channel(), covers);
          results[f].abundance[material_of_key(keys[k])] += covers;
        }
      });
    }
  }
  for (std::size_t f = 0; f < flagged.size(); ++f) {
    float sums[RC_TRUTH_SUMS];
    std::copy(std::begin(results[f].truth), std::end(results[f].truth), sums);
    const std::vector<float> abundance(results[f].abundance.begin(), results[f].abundance.end());
    PixelTerms* terms = out.terms ? &results[f].terms : nullptr;
    if (shape.environment) add_environment(flagged[f], sums, results[f].path, results[f].radiance, terms);
    if (shape.bounces) add_glow(flagged[f], results[f].path, results[f].radiance, terms);
    write_truth(flagged[f], sums, abundance.data(), out);
    host_radiance_.emplace_back(flagged[f], std::move(results[f].radiance));
    if (out.terms) out.terms[flagged[f]] = std::move(results[f].terms);
  }
}

}  // namespace raycube::render
