#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/base/cache_folder.h"
#include "host/base/error.h"
#include "host/base/text.h"
#include "host/run/chart_point.h"
#include "host/planner/cost_model.h"
#include "host/planner/judged_pixels.h"
#include "host/planner/open_share.h"
#include "host/run/camera_job.h"
#include "host/sensors/view_bounds.h"
#include "host/study/kept.h"
#include "host/study/device_timing.h"

namespace raycube::run {

namespace {

/// Rays of one timed repeat: settings with more rays a pixel are timed on fewer pixels.
constexpr double kTimedRays = 4e6;
constexpr int kReferenceBounces = 16;  ///< at least, where there is light between surfaces

/// The plan that lends the reference its grid and its ground: nothing fixed by hand, light between ground and air as
/// the table allows.
plan::Plan reference_plan(const knobs::Subject& subject, const atmos::RenderTable& table,
                          const plan::ViewBounds& view) {
  const knobs::Settings keep(subject);
  subject.simulation.plan = {};
  subject.simulation.atmosphere.adjacency = scene::Adjacency::automatic;
  return plan::make_plan(subject.simulation, *subject.instrument, table, view);
}

/// Says by which figure, and of which of its pixels, settings are held against the reference.
void judge_as_asked(study::Converged& reference, const knobs::Subject& subject, const plan::Plan& plan,
                    const std::vector<render::Tile>& tiles, const render::RenderOptions& where) {
  const scene::ToleranceMeasure& measure = subject.simulation.tolerance_of;
  reference.figure = measure.figure;
  if (measure.materials.empty()) return;
  render::Renderer renderer(subject.simulation.scene, where);
  reference.weight = planner::pixel_weights(renderer, subject.simulation, *subject.instrument, plan, tiles);
  if (std::none_of(reference.weight.begin(), reference.weight.end(), [](float weight) { return weight > 0; }))
    throw base::Error(
        base::Fault::input,
        fmt::format("'{}': none of the {} pixels that are held against the reference has any of "
                    "tolerance_materials ({}); give more --pixels, or name what it sees",
                    subject.instrument->name, render::pixels_of(tiles), fmt::join(measure.materials, ", ")));
}

struct FoundChart {
  study::ErrorFigures error;
  study::Timing timing;
};

}  // namespace

Chart chart_cube(scene::Simulation& simulation, std::size_t index, const ChartOptions& options,
                 const std::vector<std::string>& devices, const render::RenderOptions& given, Services& services) {
  scene::Instrument& instrument = simulation.instruments[index];
  const knobs::Subject subject = chart_subject(simulation, index, options.knobs);
  const knobs::Settings keep(subject);
  simulation.bounces_given = true;  // the most that the planner may choose stands for what it would
  const auto chosen = chosen_knobs(subject, options.knobs);
  const CameraJob job = prepare_camera(simulation, instrument, services);
  const plan::ViewBounds view = sensors::view_bounds(instrument);
  const std::vector<render::Tile> tiles = render::pick_tiles(instrument, simulation.seed, options.pixels);

  Chart chart;
  chart.name = instrument.name;
  chart.kind = "cube";
  chart.tolerance = simulation.tolerance, chart.measure = simulation.tolerance_of;
  chart.validated = render::pixels_of(tiles);
  study::ConvergedSettings settings;
  settings.threads = services.threads;
  settings.grid = options.reference_grid;
  const plan::Plan finest = reference_plan(subject, job.table, view);
  if (subject.between_surfaces && finest.first_lamp() > 0)
    settings.levels = std::max(simulation.bounces, kReferenceBounces);
  study::Kept kept;
  study::Converged reference = study::kept_or(
      base::cache_folder("reference").string(),
      study::key_of(simulation, instrument, finest, job.table, tiles, settings),
      [&] {
        const Step progress(services, "reference of " + instrument.name, chart.validated, "pixels");
        return study::converge(simulation, instrument, finest, job.table, tiles, settings,
                               [&](std::uint64_t more) { progress.advance(more); });
      },
      &kept);
  if (!kept.warning.empty()) services.log.warning(kept.warning);
  if (kept.found) services.log.detail(instrument.name + ": reference from the cache");
  render::RenderOptions first_device = given;
  first_device.device = devices.front();
  judge_as_asked(reference, subject, finest, tiles, first_device);
  chart.own_error = study::own_error(reference);
  chart.reference = "Embree and double, full tables, " + base::counted(2 * settings.grid * settings.grid, "sample") +
                    ", " + std::to_string(2 * settings.grid * settings.grid * settings.per_sample) +
                    " sky rays a pixel";
  if (settings.levels > 0)
    chart.reference += ", " + base::counted(2 * settings.paths, "path") + " to " + std::to_string(settings.levels) +
                       " surfaces after the first (light of the plan's components)";
  chart.what_time = "the whole image of " + std::to_string(instrument.pixels) + " x " +
                    std::to_string(instrument.lines) +
                    " pixels, without writing: rows baked once, other stages of a few strips scaled to all pixels";
  for (const std::string& number : devices) {
    render::RenderOptions where = given;
    where.device = number;
    render::Renderer renderer(simulation.scene, where);
    chart.machines.push_back(renderer.device_name());
    std::map<std::map<std::string, std::string>, FoundChart> known;  // one setting is part of several sweeps
    for_each_setting(subject, chosen, [&](ChartPoint point) {
      point.device = renderer.device_name();
      services.log.set_status("chart " + instrument.name + ": " + point.knob + " " + point.label);
      auto at = known.find(point.settings);
      if (at == known.end()) {
        plan::Plan plan;
        try {
          plan = plan::make_plan(simulation, instrument, job.table, view);
          planner::measure_open_share(renderer, simulation, instrument, plan);
        } catch (const base::Error& error) {
          if (error.fault() != base::Fault::input) throw;
          point.refused = error.what();
          chart.points.push_back(std::move(point));
          return;
        }
        FoundChart found;
        found.error = study::error_of(
            reference, study::device_radiance(renderer, instrument, plan, simulation.sun, simulation.seed, tiles));
        const double samples = static_cast<double>(instrument.samples_u) * instrument.samples_v;
        const double rays = planner::pixel_counts(plan, samples, plan.sky.rays).rays();
        const auto timed =
            static_cast<std::uint64_t>(std::clamp(kTimedRays / rays, 64.0, static_cast<double>(options.timed_pixels)));
        found.timing = study::time_image(renderer, instrument, plan, simulation.sun, simulation.seed,
                                         render::timing_tiles(instrument, timed), options.repeats);
        at = known.emplace(point.settings, found).first;
      }
      const FoundChart& found = at->second;
      point.error = found.error.worst, point.error_low = found.error.low, point.error_high = found.error.high;
      point.rms = found.error.rms, point.p95 = found.error.p95,
      point.worst_band = static_cast<int>(found.error.band) + 1;
      point.time_s = found.timing.median_s, point.time_low_s = found.timing.low_s,
      point.time_high_s = found.timing.high_s;
      point.rays = found.timing.rays_per_pixel, point.terms = found.timing.terms_per_pixel,
      point.stage_s = found.timing.stage_s;
      chart.points.push_back(std::move(point));
    });
  }
  services.log.set_status("");
  mark_front(chart);
  return chart;
}

}  // namespace raycube::run
