#include "host/run/spread_image.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/plan/band_truth.h"

namespace raycube::run {
namespace {

constexpr std::size_t kMostKept_bytes = 128u << 20;  ///< of weights that each pixel has for itself

}  // namespace

SpreadImage::SpreadImage(const scene::Simulation& simulation, const CameraJob& job, int threads, render::StripSink sink)
    : cells_(*job.cells),
      sink_(std::move(sink)),
      threads_(threads),
      columns_(render_plan(job)->columns()),
      layers_(render::truth_layer_names(simulation.scene, *job.instrument).size()),
      materials_(scene::named_count(simulation.scene)),
      shares_(render::share_layers(simulation.scene, *job.instrument)),
      derived_(simulation.scene, *job.instrument) {
  const std::size_t bands = cells_.seen.bands.size();
  for (const sensors::BandOfCells& band : cells_.bands) columns_of_.push_back(band.from);
  columns_of_.emplace_back();
  std::size_t column = cells_.rendered.bands.size();
  for (const scene::BandTruth truth : plan::truth_columns(job.plan, *job.instrument))
    for (std::size_t b = 0; b < bands; ++b)
      columns_of_[scene::band_truth_entry(truth).kind == scene::BandTruthKind::part ? b : bands].push_back(column++);
  size_weights();
  along_ = weights_of(1, 0);
  const auto pixels = static_cast<std::size_t>(cells_.seen.pixels);
  const std::size_t own = cells_.most_keystone_px > 0 ? pixels : 1;
  if (own > 1 && own * along_.columns * static_cast<std::size_t>(terms_) * static_cast<std::size_t>(2 * half_[0] + 1) *
                         sizeof(float) >
                     kMostKept_bytes)
    return;
  across_.resize(own);
  base::for_each_index(own, threads_, [&](std::size_t p) { across_[p] = weights_of(0, static_cast<int>(p)); });
}

/// Products of weights to their place in these columns.
void SpreadImage::fill(Weights& weights, const std::vector<sensors::Taps>& terms,
                       const std::vector<std::size_t>& columns) const {
  for (std::size_t r = 0; r < terms.size(); ++r) {
    const int half = static_cast<int>(terms[r].size() / 2);
    for (int k = -half; k <= half; ++k) {
      if (std::abs(k) > weights.half) continue;  // a shift's end, where nothing is
      float* to = weights.value.data() + weights.place(static_cast<int>(r), k);
      for (const std::size_t column : columns)
        to[column] = static_cast<float>(terms[r][static_cast<std::size_t>(k + half)]);
    }
  }
}

void SpreadImage::size_weights() {
  half_ = cells_.own();
  for (const sensors::BandOfCells& band : cells_.bands) {
    const sensors::SpreadKernel& kernel = cells_.kernels[band.kernel];
    terms_ = std::max(terms_, static_cast<int>(kernel.terms.size()));
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double off =
          std::abs(band.offset_cells[axis]) + (axis == 0 ? cells_.most_keystone_px * cells_.grid.cells[0] : 0);
      const int reach = off == 0 ? 0 : static_cast<int>(std::ceil(off)) + sensors::kShiftReach;
      half_[axis] = std::max(half_[axis], kernel.half[axis] + reach);
    }
  }
}

/// Of all columns along an axis, at a pixel: keystone looks aside across.
SpreadImage::Weights SpreadImage::weights_of(int axis, int pixel) const {
  const auto at = static_cast<std::size_t>(axis);
  Weights out;
  out.half = half_[at], out.columns = columns_;
  out.value.assign(static_cast<std::size_t>(terms_) * static_cast<std::size_t>(2 * out.half + 1) * columns_, 0.0f);
  std::vector<sensors::Taps> terms;
  for (std::size_t b = 0; b < cells_.bands.size(); ++b) {
    const sensors::BandOfCells& band = cells_.bands[b];
    const double cells =
        band.offset_cells[at] + (axis == 0 ? sensors::keystone_px(cells_.seen, b, pixel) * cells_.grid.cells[0] : 0);
    const int longer = cells == 0 ? 0 : static_cast<int>(std::ceil(std::abs(cells))) + sensors::kShiftReach;
    terms.clear();
    for (const auto& term : cells_.kernels[band.kernel].terms) {
      const sensors::Taps& own = axis == 0 ? term.across : term.along;
      terms.push_back(cells == 0 ? own : sensors::shifted(own, cells, longer));
    }
    fill(out, terms, columns_of_[b]);
  }
  const auto own = static_cast<std::size_t>(2 * cells_.own()[at] + 1);
  terms = {sensors::Taps(own, 1.0 / static_cast<double>(own))};
  fill(out, terms, columns_of_.back());
  return out;
}

void SpreadImage::add(const render::Strip& strip) {
  const int pixels = cells_.rendered.pixels, samples = strip.samples > 0 ? strip.samples : pixels;
  for (int l = 0; l < strip.lines; ++l) {
    CellLine& line = waiting_[strip.first_line + l];
    if (line.radiance.empty()) {
      line.radiance.resize(static_cast<std::size_t>(pixels) * columns_);
      line.truth.resize(static_cast<std::size_t>(pixels) * layers_);
    }
    const auto from = static_cast<std::size_t>(l) * static_cast<std::size_t>(samples),
               to = static_cast<std::size_t>(strip.first_sample), count = static_cast<std::size_t>(samples);
    std::copy_n(strip.radiance + from * columns_, count * columns_, line.radiance.data() + to * columns_);
    std::copy_n(strip.truth + from * layers_, count * layers_, line.truth.data() + to * layers_);
    line.filled += samples;
  }
  int lines = 0;
  for (auto it = waiting_.find(next_cell_);
       it != waiting_.end() && it->first == next_cell_ + lines && it->second.filled == pixels; ++it)
    ++lines;
  if (lines > 0) take(next_cell_, lines);
}

int SpreadImage::last_cell_of(int pixel_line) const { return cells_.middle(1, pixel_line) + along_.half; }

/// The next lines of cells into the sums of all pixels that see them; lines of pixels that are whole go out.
void SpreadImage::take(int first_line, int lines) {
  const auto pixels = static_cast<std::size_t>(cells_.seen.pixels);
  const int end = first_line + lines;
  for (int i = next_pixel_; i < cells_.seen.lines && cells_.middle(1, i) - along_.half < end; ++i) {
    PixelLine& line = open_[i];
    if (!line.sums.empty()) continue;
    line.sums.assign(pixels * columns_, 0.0f);
    line.truth.assign(pixels * layers_, 0.0), line.middle.assign(pixels * layers_, 0.0f);
  }
  base::for_each_index(pixels, threads_, [&](std::size_t j) { take_pixel(static_cast<int>(j), first_line, lines); });
  for (int l = first_line; l < end; ++l) count_missed(l, waiting_.at(l)), waiting_.erase(l);
  next_cell_ = end;
  while (next_pixel_ < cells_.seen.lines && last_cell_of(next_pixel_) < end) {
    send(next_pixel_, open_.at(next_pixel_));
    open_.erase(next_pixel_++);
  }
}

/// Of one column of pixels: a row's weights over each line of cells, then a column's.
void SpreadImage::take_pixel(int pixel, int first_line, int lines) {
  const Weights own = across_.empty() ? weights_of(0, pixel) : Weights();
  const Weights& across = across_.empty()       ? own
                          : across_.size() == 1 ? across_.front()
                                                : across_[static_cast<std::size_t>(pixel)];
  const std::size_t n = columns_;
  const int middle = cells_.middle(0, pixel);
  std::vector<float> rows(static_cast<std::size_t>(terms_) * n);
  for (int l = first_line; l < first_line + lines; ++l) {
    const CellLine& cells = waiting_.at(l);
    std::fill(rows.begin(), rows.end(), 0.0f);
    for (int r = 0; r < terms_; ++r) {
      float* sum = rows.data() + static_cast<std::size_t>(r) * n;
      for (int k = -across.half; k <= across.half; ++k) {
        const float *weight = across.at(r, k),
                    *light = cells.radiance.data() + static_cast<std::size_t>(middle + k) * n;
        for (std::size_t c = 0; c < n; ++c) sum[c] += weight[c] * light[c];
      }
    }
    for (auto& [i, line] : open_) {
      const int k = l - cells_.middle(1, i);
      if (std::abs(k) > along_.half) continue;
      float* sum = line.sums.data() + static_cast<std::size_t>(pixel) * n;
      for (int r = 0; r < terms_; ++r) {
        const float *weight = along_.at(r, k), *row = rows.data() + static_cast<std::size_t>(r) * n;
        for (std::size_t c = 0; c < n; ++c) sum[c] += weight[c] * row[c];
      }
    }
    take_truth(pixel, l, cells);
  }
}

/// The truth of a pixel is that of its own cells, where it should look.
void SpreadImage::take_truth(int pixel, int line, const CellLine& cells) {
  const std::array<int, 2> own = cells_.own();
  const auto at = static_cast<std::size_t>(pixel) * layers_;
  for (auto& [i, to] : open_) {
    const int from_middle = line - cells_.middle(1, i);
    if (std::abs(from_middle) > own[1]) continue;
    for (int k = -own[0]; k <= own[0]; ++k) {
      const float* from = cells.truth.data() + static_cast<std::size_t>(cells_.middle(0, pixel) + k) * layers_;
      render::add_truth(from, shares_, to.truth.data() + at);
      if (k == 0 && from_middle == 0) std::copy_n(from, layers_, to.middle.data() + at);
    }
  }
}

/// Around the image cells that met nothing are dark in its pixels.
void SpreadImage::count_missed(int line, const CellLine& cells) {
  const bool outside_line = line < cells_.margin_px[1] * cells_.grid.cells[1] ||
                            line >= (cells_.margin_px[1] + cells_.seen.lines) * cells_.grid.cells[1];
  const int first = cells_.margin_px[0] * cells_.grid.cells[0],
            end = (cells_.margin_px[0] + cells_.seen.pixels) * cells_.grid.cells[0];
  for (int c = 0; c < cells_.rendered.pixels; ++c) {
    if (!outside_line && c >= first && c < end) continue;
    missed_ += 1 - double{cells.truth[static_cast<std::size_t>(c) * layers_ + render::truth::hit_fraction]};
    ++around_;
  }
}

std::optional<std::string> SpreadImage::warning() const {
  if (missed_ <= 1e-6 * static_cast<double>(around_)) return std::nullopt;
  return fmt::format(
      "{}: {:.3g} % of what lies around the image, {} pixels wide across and {} lines along, met nothing, and is dark "
      "in "
      "what its point spreads mix into the pixels at its edges; widen the scene",
      cells_.seen.name, 100 * missed_ / static_cast<double>(around_), cells_.margin_px[0], cells_.margin_px[1]);
}

void SpreadImage::send(int pixel_line, const PixelLine& line) {
  const auto pixels = static_cast<std::size_t>(cells_.seen.pixels);
  const std::size_t bands = cells_.seen.bands.size(), of_cells = cells_.rendered.bands.size(),
                    columns = bands + columns_ - of_cells;
  std::vector<float> radiance(pixels * columns), truth(pixels * layers_);
  const bool smiles = bands != of_cells;
  for (std::size_t j = 0; j < pixels; ++j) {
    const float* from = line.sums.data() + j * columns_;
    float* to = radiance.data() + j * columns;
    for (std::size_t b = 0; smiles && b < bands; ++b) {
      const sensors::BandOfCells& band = cells_.bands[b];
      const auto share = band.shares(sensors::smile_um(cells_.seen, b, static_cast<double>(j)));
      double sum = 0;
      for (std::size_t i = 0; i < share.size(); ++i) sum += share[i] * static_cast<double>(from[band.from[i]]);
      to[b] = static_cast<float>(sum);
    }
    if (!smiles) std::copy_n(from, bands, to);
    std::copy_n(from + of_cells, columns_ - of_cells, to + bands);
    render::mean_truth(line.truth.data() + j * layers_, cells_.own_count(), materials_, shares_,
                       truth.data() + j * layers_);
    render::copy_angles_of_view(line.middle.data() + j * layers_, truth.data() + j * layers_);
  }
  derived_.fill(pixels, truth.data());
  render::Strip strip;
  strip.first_line = pixel_line, strip.lines = 1;
  strip.radiance = radiance.data(), strip.truth = truth.data(), strip.columns = columns;
  sink_(strip);
}

void SpreadImage::finish() const {
  if (next_pixel_ != cells_.seen.lines)
    throw base::Error(base::Fault::bug,
                      fmt::format("{} of {} lines of pixels have all their cells", next_pixel_, cells_.seen.lines));
}

}  // namespace raycube::run
