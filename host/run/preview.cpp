#include "host/run/preview.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "host/base/planck.h"
#include "host/plan/plan.h"
#include "host/planner/sample_pattern.h"
#include "host/run/air_table.h"
#include "host/run/camera_job.h"
#include "host/run/cube_products.h"
#include "host/sensors/view_bounds.h"

namespace raycube::run {

namespace {

/// Of what a picture can show: a percent of the sky, a node or two.
constexpr double kTolerance = 0.05;
/// Of the sky, taken for granted on every surface.
constexpr float kOpenShare = 0.5f;
/// Added to the seed for each pass.
constexpr std::uint64_t kPass = 0x9e3779b9u;
/// Pixels of a line that the kernels see together.
constexpr int kGroup = RC_GROUP_WIDTH;

/// Blue to red as a quicklook has them, or one band.
scene::Instrument with_shown_bands(const scene::Instrument& instrument) {
  scene::Instrument out = instrument;
  out.bands.clear();
  for (const int band : shown_bands(instrument)) out.bands.push_back(instrument.bands[static_cast<std::size_t>(band)]);
  out.first_samples = 0;
  out.small_objects = scene::SmallObjects::off, out.standard_error = scene::StandardError::off;
  planner::give_samples(out, kPreviewSamples);
  return out;
}

/// The clear sky takes milliseconds where the layered model takes seconds; it knows no heat.
void take_quick_air(scene::Simulation& simulation, const scene::Instrument& shown) {
  simulation.tolerance = kTolerance;
  simulation.plan = {};
  simulation.atmosphere.adjacency = scene::Adjacency::off;
  if (!base::asks_for_heat(band_range(shown.bands).second)) simulation.atmosphere.layered.reset();
}

/// Radiances of every step-th line and column, summed over passes.
class Picture {
 public:
  Picture(const scene::Instrument& shown, std::int64_t most_pixels) : shown_(shown) {
    const auto pixels = [&] { return std::int64_t{width()} * height(); };
    while (pixels() > most_pixels) ++step_;
    sum_.assign(static_cast<std::size_t>(pixels()) * bands(), 0.0);
  }

  int step() const { return step_; }
  int width() const { return (shown_.pixels + step_ - 1) / step_; }
  int height() const { return (shown_.lines + step_ - 1) / step_; }

  /// Of each line that is shown, whole groups that hold the columns shown.
  std::vector<render::Tile> tiles() const {
    std::vector<render::Tile> out;
    for (int y = 0; y < height(); ++y) {
      if (step_ <= kGroup) {
        out.push_back({y * step_, 1, 0, shown_.pixels});
        continue;
      }
      for (int x = 0; x < width(); ++x) {
        const int column = x * step_ / kGroup * kGroup;
        out.push_back({y * step_, 1, column, std::min(kGroup, shown_.pixels - column)});
      }
    }
    return out;
  }

  void add(const render::PixelProbe& probe) {
    const int y = probe.tile.first_line / step_, end = probe.tile.first_column + probe.tile.columns;
    for (int x = (probe.tile.first_column + step_ - 1) / step_; x * step_ < end; ++x) {
      const auto from = static_cast<std::size_t>(x * step_ - probe.tile.first_column) * bands();
      const auto to =
          (static_cast<std::size_t>(y) * static_cast<std::size_t>(width()) + static_cast<std::size_t>(x)) * bands();
      for (std::size_t b = 0; b < bands(); ++b) sum_[to + b] += static_cast<double>(probe.radiance[from + b]);
    }
  }

  void write(base::OutputFile& file, int passes) const {
    std::vector<float> mean;
    for (const double sum : sum_) mean.push_back(static_cast<float>(sum / passes));
    std::vector<int> channels;
    std::vector<std::string> names;
    for (std::size_t b = 0; b < bands(); ++b) {
      channels.push_back(static_cast<int>(b));
      names.push_back(fmt::format("{:.0f} nm", 1e3 * shown_.bands[b].center_um));
    }
    products::Quicklook picture(width(), height(), channels);
    products::Strip strip;
    strip.lines = height(), strip.values = mean.data(), strip.pixel_stride = bands();
    picture.add(strip);
    picture.write(file, names);
  }

 private:
  std::size_t bands() const { return shown_.bands.size(); }

  const scene::Instrument& shown_;
  int step_ = 1;
  std::vector<double> sum_;  ///< [y][x][band]
};

}  // namespace

void preview(render::Renderer& renderer, scene::Simulation& simulation, const scene::Instrument& instrument,
             const PreviewSettings& settings, Services& services, const PreviewSink& sink) {
  const scene::Instrument shown = with_shown_bands(instrument);
  take_quick_air(simulation, shown);
  const plan::ViewBounds view = sensors::view_bounds(shown);
  const atmos::RenderTable table = air_table(air_request(simulation, shown, view.sensor_height_m), services);
  plan::Plan plan = plan::make_plan(simulation, shown, table, view, services.threads);
  plan.sky.rays = kPreviewDirections, plan.sky.paths_per_two = 1;
  plan.sky.open_share.assign(simulation.scene.surfaces.size(), kOpenShare);

  Picture picture(shown, settings.most_pixels);
  const auto tiles = picture.tiles();
  const int passes = (settings.samples + kPreviewSamples - 1) / kPreviewSamples;
  const Step progress(services, "preview " + shown.name, static_cast<std::uint64_t>(passes), "passes");
  for (int pass = 1; pass <= passes; ++pass) {
    renderer.probe_together(shown, plan, simulation.sun, simulation.seed + kPass * static_cast<std::uint64_t>(pass),
                            tiles, [&](const render::PixelProbe& probe) { picture.add(probe); });
    if (pass == passes || (pass & (pass - 1)) == 0)
      sink({picture.width(), picture.height(), picture.step(), pass * kPreviewSamples, pass == passes},
           [&](base::OutputFile& file) { picture.write(file, pass); });
    progress.advance();
  }
}

}  // namespace raycube::run
