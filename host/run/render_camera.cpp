#include "host/run/render_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/memory.h"
#include "host/base/text.h"
#include "host/base/timing.h"
#include "host/cl/device.h"
#include "host/planner/own_error.h"
#include "host/planner/plan_lines.h"
#include "host/planner/seconds_text.h"
#include "host/run/cube_products.h"
#include "host/run/forecast.h"
#include "host/run/load_job.h"
#include "host/run/spread_image.h"

namespace raycube::run {

namespace {

/// What is known of the error: one line in the log, a member of the record, a warning where the tolerance is
/// not kept. A run that is whole is not lost because its error cannot be told.
void add_error(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job,
               const render::ReplicateSpread& spread, products::RunRecord& record, Services& services) {
  planner::OwnError error;
  try {
    error = planner::own_error(renderer, simulation, *job.instrument, job.plan, job.table, job.decision, spread,
                               services.threads);
  } catch (const base::Error& failure) {
    if (failure.fault() == base::Fault::interrupted) throw;
    services.log.warning(job.instrument->name + ": its error is not known: " + failure.what());
    return;
  } catch (const std::bad_alloc&) {
    services.log.warning(job.instrument->name + ": its error is not known: there is not enough memory for a trial");
    return;
  }
  const std::string text = job.instrument->name + ": " + planner::own_error_text(error);
  record.more_json.emplace_back("error", planner::own_error_json(error));
  if (!error.kept() && !job.decision.estimated) {  // what a trial found is among the plan's notes
    services.log.warning(text);
    record.warnings.push_back(text);
  } else {
    services.log.info(text);
  }
}

/// Seconds from the first tile to the last byte, of the clock and of all processors.
struct Took {
  double render_s = 0, processor_s = 0;
};

/// How it came about: device, sizes, times, plan.
products::RunRecord record_of(const scene::Simulation& simulation, const CameraJob& job, render::Renderer& renderer,
                              const render::RenderOptions& options, const Destination& destination,
                              const render::RenderStatistics& statistics, const Took& took, int threads) {
  const auto& instrument = *job.instrument;
  const cl::DeviceInfo device = cl::find_device(options.device).info();
  products::RunRecord record;
  record.command = destination.command;
  record.instrument = instrument.name;
  record.scene_hash = simulation.scene.content_hash;
  record.seed = simulation.seed;
  record.platform = device.platform;
  record.device = device.name;
  record.driver = device.driver;
  record.opencl_version = device.version;
  record.compute_units = static_cast<int>(device.compute_units);
  record.threads = threads > 0 ? threads : static_cast<int>(device.compute_units);
  record.program_hash = statistics.program_hash;
  record.kernel_variants = statistics.kernel_variants;
  record.samples = job.image().pixels;
  record.lines = job.image().lines;
  record.bands = static_cast<std::int64_t>(job.image().bands.size());
  record.samples_per_pixel = instrument.all_samples() * (job.cells ? job.cells->own_count() : 1);
  record.stage_s = {
      {"load", destination.load_s}, {"atmosphere", job.table_s}, {"kernels", job.kernels_s}, {"plan", job.plan_s}};
  for (const auto& stage : statistics.stage_s) record.stage_s.push_back(stage);
  record.total_s = destination.load_s + job.table_s + job.kernels_s + job.plan_s + took.render_s;
  record.processor_s = {{"plan", job.plan_processor_s}, {"render", took.processor_s}};
  record.rays = statistics.primary_rays + statistics.sun_rays + statistics.sky_rays;
  record.rays_per_s = static_cast<double>(record.rays) / took.render_s;
  record.band_samples_per_s = static_cast<double>(statistics.band_samples) / took.render_s;
  record.memory_budget_bytes = options.memory_bytes;
  record.peak_memory_bytes = base::peak_resident_bytes();
  record.device_memory_bytes = device.global_memory_bytes;
  record.configuration_json = simulation.resolved_json;
  record.plan_json = plan_json(job).dump(2);
  const nlohmann::json rows = {{"overflow_pixels", statistics.overflow_pixels},
                               {"per_sample_pixels", statistics.per_sample_pixels},
                               {"light_paths", statistics.paths},
                               {"terms_p50", statistics.terms_p50},
                               {"terms_p95", statistics.terms_p95},
                               {"tile_lines", statistics.tile_lines},
                               {"tile_columns", statistics.tile_columns}};
  record.more_json = {{"atmosphere", job.table.provenance_json},
                      {"rows", rows.dump()},
                      {"trace_program_hash", nlohmann::json(statistics.trace_program_hash).dump()},
                      {"launches", render::tuning_json(renderer.tuning())}};
  record.warnings = light_notices(simulation, instrument);
  record.warnings.insert(record.warnings.end(), job.notices.begin(), job.notices.end());
  return record;
}

/// What share of an adaptive image was rendered anew with all samples.
void add_adaptive(const scene::Instrument& instrument, const render::RenderStatistics& statistics,
                  products::RunRecord& record, Services& services) {
  if (!instrument.adaptive()) return;
  const double refined = static_cast<double>(statistics.refined_pixels) /
                         static_cast<double>(std::max<std::uint64_t>(1, statistics.adaptive_pixels));
  record.more_json.emplace_back(
      "adaptive", nlohmann::json({{"first", instrument.first_samples}, {"refined_share", refined}}).dump());
  services.log.info(
      fmt::format("{}: {:.1f} % of the pixels rendered anew with all samples", instrument.name, 100 * refined));
}

/// How many pixels small objects had rendered with more samples.
void add_small_objects(const CameraJob& job, const render::RenderStatistics& statistics, products::RunRecord& record,
                       Services& services) {
  if (statistics.small_object_pixels.empty()) return;
  nlohmann::json levels = nlohmann::json::array();
  for (const auto& [samples, pixels] : statistics.small_object_pixels)
    levels.push_back({{"samples_per_pixel", samples}, {"pixels", pixels}});
  record.more_json.emplace_back("small_objects", levels.dump());
  services.log.info(fmt::format("{}: {} in {}, rendered anew with up to {} samples", job.instrument->name,
                                base::counted(job.decision.small.scarce, "small object"),
                                base::counted(job.decision.small.pixels, "pixel"),
                                statistics.small_object_pixels.rbegin()->first));
}

/// What the render will take and err by, before it begins.
void say_what_it_takes(const CameraJob& job, Services& services) {
  const planner::Decision& d = job.decision;
  services.log.info(fmt::format(
      "{}: {:.0f} samples and {:.0f} sky rays a pixel, some {} s on two cores; {}", job.instrument->name,
      d.counts.samples, d.counts.sky_rays, planner::seconds_text(nominal_render_s(job)),
      d.total_error >= 0
          ? fmt::format("estimated error {} of {:.3g} %", planner::percent_text(d.total_error), 100 * d.tolerance)
          : std::string("its error is judged when it is done")));
}

void add_warning(const std::string& text, products::RunRecord& record, Services& services) {
  services.log.warning(text);
  record.warnings.push_back(text);
}

/// The image into its products, strip by strip.
render::RenderStatistics render_into(CubeProducts& output, const scene::Simulation& simulation, const CameraJob& job,
                                     const plan::Plan& plan, render::Renderer& renderer, const Services& services,
                                     std::vector<std::string>& warnings) {
  const auto& instrument = *job.instrument;
  std::optional<SpreadImage> spread;
  if (job.cells)
    spread.emplace(simulation, job, services.threads, [&](const render::Strip& strip) { output.add(strip); });
  const Step step(services, "render " + instrument.name, std::uint64_t(instrument.pixels) * instrument.lines, "pixels");
  std::uint64_t reported = 0;
  auto statistics = renderer.render(
      instrument, plan, simulation.sun, simulation.seed,
      [&](const render::Strip& strip) { spread ? spread->add(strip) : output.add(strip); },
      [&](std::uint64_t done, std::uint64_t) {
        step.advance(done - reported);
        reported = done;
      },
      job.decision.image.get());
  if (!spread) return statistics;
  spread->finish();
  if (const auto beyond = spread->warning()) services.log.warning(*beyond), warnings.push_back(*beyond);
  return statistics;
}

}  // namespace

CameraRun render_camera(const scene::Simulation& simulation, const CameraJob& job, render::Renderer& renderer,
                        const render::RenderOptions& options, const Destination& destination, Services& services) {
  const auto& instrument = *job.instrument;
  const auto start = std::chrono::steady_clock::now();
  const double processor_before_s = base::processor_seconds();
  // Refuses a memory that is too small before anything is made.
  const auto plan = render_plan(job);
  renderer.tile_size(instrument, *plan, renderer.tuning().tile_samples);
  say_what_it_takes(job, services);
  CubeProducts output(destination.folder, destination.if_exists, simulation, job);
  std::vector<std::string> warnings;
  const auto statistics = render_into(output, simulation, job, *plan, renderer, services, warnings);
  output.complete();
  Took took{base::seconds_since(start), base::processor_seconds() - processor_before_s};
  if (job.decision.image)  // which the planner rendered
    took.render_s += job.decision.image->render_s, took.processor_s += job.decision.image->processor_s;

  products::RunRecord record =
      record_of(simulation, job, renderer, options, destination, statistics, took, services.threads);
  record.warnings.insert(record.warnings.end(), warnings.begin(), warnings.end());
  add_adaptive(instrument, statistics, record, services);
  if (const auto bright = output.warning()) add_warning(*bright, record, services);
  add_small_objects(job, statistics, record, services);
  for (const auto* more : {&job.plan.notices, &job.decision.notes})
    record.warnings.insert(record.warnings.end(), more->begin(), more->end());
  record.more_json.emplace_back("missed_samples", output.missed().json());
  if (output.missed().any()) add_warning(output.missed().text(), record, services);
  add_error(renderer, simulation, job, statistics.spread, record, services);
  output.publish(record, services);
  services.log.info(fmt::format("{}: {} x {} pixels, {}, {:.1f} s, {:.3g} rays/s, {}", instrument.name,
                                job.image().pixels, job.image().lines, base::counted(job.image().bands.size(), "band"),
                                took.render_s, record.rays_per_s, destination.folder));
  return {
      instrument.name,   destination.folder,       record.digest, destination.folder + "/radiance.img", took.render_s,
      record.rays_per_s, record.band_samples_per_s};
}

}  // namespace raycube::run
