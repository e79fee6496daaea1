// raycube render: a simulation file to radiance cubes with truth.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/memory.h"
#include "host/base/progress.h"
#include "host/cl/device.h"
#include "host/cli/cube_products.h"
#include "host/cli/dry_run.h"
#include "host/cli/input_check.h"
#include "host/cli/lidar_job.h"
#include "host/cli/missed_samples.h"
#include "host/cli/render_lidar.h"
#include "host/cli/simulation_job.h"
#include "host/planner/own_error.h"
#include "host/planner/plan_file.h"

namespace raycube::cli {

namespace {

struct Options {
  std::string file, instrument, plan;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// What is known of the error: one line in the log, a member of the record, a warning where the tolerance is
/// not kept. A run that is whole is not lost because its error cannot be told.
void add_error(render::Renderer& renderer, const scene::Simulation& simulation, const InstrumentJob& job,
               products::RunRecord& record, Context& context) {
  planner::OwnError error;
  try {
    error = planner::own_error(renderer, simulation, *job.instrument, job.plan, job.table, job.decision,
                               context.common.threads);
  } catch (const base::Error& failure) {
    if (failure.fault() == base::Fault::interrupted) throw;
    context.log.warning(job.instrument->name + ": its error is not known: " + failure.what());
    return;
  } catch (const std::bad_alloc&) {
    context.log.warning(job.instrument->name + ": its error is not known: there is not enough memory for a trial");
    return;
  }
  const std::string text = job.instrument->name + ": " + planner::own_error_text(error);
  record.more_json.emplace_back("error", planner::own_error_json(error));
  if (!error.kept() && !job.decision.estimated) {  // what a trial found is among the plan's notes
    context.log.warning(text);
    record.warnings.push_back(text);
  } else {
    context.log.info(text);
  }
}

nlohmann::json render_one(const scene::Simulation& simulation, const InstrumentJob& job, render::Renderer& renderer,
                          const cl::DeviceInfo& device, const std::filesystem::path& folder, double load_s,
                          Context& context) {
  const auto& instrument = *job.instrument;
  const auto start = std::chrono::steady_clock::now();
  renderer.tile_size(instrument, job.plan,
                     renderer.tuning().tile_samples);  // refuses a --memory that is too small before anything is made
  CubeProducts output(folder.string(), context.common.overwrite ? base::IfExists::replace : base::IfExists::refuse,
                      simulation, job);
  base::Progress progress(context.log, "render " + instrument.name, std::uint64_t(instrument.pixels) * instrument.lines,
                          "pixels");
  MissedSamples missed(simulation, instrument);
  std::uint64_t reported = 0;
  const auto statistics = renderer.render(
      instrument, job.plan, simulation.sun, simulation.seed,
      [&](const render::Strip& strip) {
        output.add(strip);
        missed.add(strip);
      },
      [&](std::uint64_t done, std::uint64_t) {
        progress.advance(done - reported);
        reported = done;
      });
  const double render_s = seconds_since(start);

  products::RunRecord record;
  record.command = context.command_line;
  record.instrument = instrument.name;
  record.scene_hash = simulation.scene.content_hash;
  record.seed = simulation.seed;
  record.platform = device.platform;
  record.device = device.name;
  record.driver = device.driver;
  record.opencl_version = device.version;
  record.compute_units = static_cast<int>(device.compute_units);
  record.threads = context.common.threads > 0 ? context.common.threads : static_cast<int>(device.compute_units);
  record.program_hash = statistics.program_hash;
  record.kernel_variants = {statistics.build_options};
  record.samples = instrument.pixels;
  record.lines = instrument.lines;
  record.bands = static_cast<std::int64_t>(instrument.bands.size());
  record.samples_per_pixel = instrument.samples_u * instrument.samples_v;
  record.stage_s = {{"load", load_s}, {"atmosphere", job.table_s}, {"plan", job.plan_s}};
  for (const auto& stage : statistics.stage_s) record.stage_s.push_back(stage);
  record.total_s = load_s + job.table_s + job.plan_s + render_s;
  record.rays = statistics.primary_rays + statistics.sun_rays + statistics.sky_rays;
  record.rays_per_s = static_cast<double>(record.rays) / render_s;
  record.band_samples_per_s = static_cast<double>(statistics.band_samples) / render_s;
  record.memory_budget_bytes = context.common.memory_bytes;
  record.peak_memory_bytes = base::peak_resident_bytes();
  record.device_memory_bytes = device.global_memory_bytes;
  record.configuration_json = simulation.resolved_json;
  record.plan_json = job.plan.report_json;
  const nlohmann::json rows = {{"overflow_pixels", statistics.overflow_pixels},
                               {"per_sample_pixels", statistics.per_sample_pixels},
                               {"terms_p50", statistics.terms_p50},
                               {"terms_p95", statistics.terms_p95},
                               {"tile_lines", statistics.tile_lines},
                               {"tile_columns", statistics.tile_columns}};
  record.more_json = {{"atmosphere", job.table.provenance_json},
                      {"rows", rows.dump()},
                      {"trace_program_hash", nlohmann::json(statistics.trace_program_hash).dump()},
                      {"launches", render::tuning_json(renderer.tuning())}};
  if (instrument.adaptive()) {
    const double refined = static_cast<double>(statistics.refined_pixels) /
                           static_cast<double>(std::max<std::uint64_t>(1, statistics.adaptive_pixels));
    record.more_json.emplace_back(
        "adaptive", nlohmann::json({{"first", instrument.first_samples}, {"refined_share", refined}}).dump());
    context.log.info(
        fmt::format("{}: {:.1f} % of the pixels rendered anew with all samples", instrument.name, 100 * refined));
  }
  record.warnings = light_notices(simulation, instrument);
  record.warnings.insert(record.warnings.end(), job.notices.begin(), job.notices.end());
  if (const auto bright = output.warning()) {
    context.log.warning(*bright);
    record.warnings.push_back(*bright);
  }
  if (!statistics.small_object_pixels.empty()) {
    nlohmann::json levels = nlohmann::json::array();
    for (const auto& [samples, pixels] : statistics.small_object_pixels)
      levels.push_back({{"samples_per_pixel", samples}, {"pixels", pixels}});
    record.more_json.emplace_back("small_objects", levels.dump());
    context.log.info(fmt::format("{}: {} small objects in {} pixels, rendered anew with up to {} samples",
                                 instrument.name, job.decision.small.scarce, job.decision.small.pixels,
                                 statistics.small_object_pixels.rbegin()->first));
  }
  for (const auto* more : {&job.plan.notices, &job.decision.notes})
    record.warnings.insert(record.warnings.end(), more->begin(), more->end());
  record.more_json.emplace_back("missed_samples", missed.json());
  if (missed.any()) {
    context.log.warning(missed.text());
    record.warnings.push_back(missed.text());
  }
  add_error(renderer, simulation, job, record, context);
  output.publish(record);
  context.log.info(fmt::format("{}: {} x {} pixels, {} bands, {:.1f} s, {:.3g} rays/s, {}", instrument.name,
                               instrument.pixels, instrument.lines, instrument.bands.size(), render_s,
                               record.rays_per_s, folder.string()));
  return {{"name", instrument.name},
          {"folder", folder.string()},
          {"digest", record.digest},
          {"seconds", render_s},
          {"rays_per_s", record.rays_per_s},
          {"band_samples_per_s", record.band_samples_per_s},
          {"cube", (folder / "radiance.img").string()}};
}

std::vector<std::string> names_of(const std::vector<const scene::Instrument*>& instruments,
                                  const std::vector<const scene::Lidar*>& lidars) {
  std::vector<std::string> names;
  for (const auto* instrument : instruments) names.push_back(instrument->name);
  for (const auto* lidar : lidars) names.push_back(lidar->name);
  return names;
}

/// What a run has done so far, for the message of an error that ends it.
struct Done {
  std::vector<std::string> names;  ///< of all its instruments, in order
  nlohmann::json whole = nlohmann::json::array();
};

int run(const Options& options, Context& context, Done& done) {
  const auto start = std::chrono::steady_clock::now();
  const scene::Simulation simulation = load_job(options.file, context);
  const double load_s = seconds_since(start);
  const auto instruments = pick_instruments(simulation, options.instrument);
  const auto lidars = pick_lidars(simulation, options.instrument);
  const std::filesystem::path out = context.common.output.empty() ? "out" : context.common.output;
  const auto settings = render_options(context.common);
  done.names = names_of(instruments, lidars);
  if (!context.common.dry_run)
    for (const auto& name : done.names) check_output_place((out / name).string(), context.common.overwrite);
  check_inputs(simulation, instruments, lidars, true);
  std::optional<planner::PlanFile> replay;
  if (!options.plan.empty()) {
    replay = planner::read_plan_file(options.plan);
    planner::require_match(*replay, simulation, options.plan);
  }
  Planning planning{nullptr, replay ? &*replay : nullptr, options.plan, false};
  std::optional<render::Renderer> renderer;
  for (const auto* instrument : instruments) {
    try {
      if (!renderer) renderer.emplace(simulation.scene, settings);
    } catch (const base::Error& error) {
      if (error.fault() != base::Fault::device || !context.common.dry_run) throw;
      context.log.warning(std::string("the time cannot be estimated, nor the errors of samples and sky directions: ") +
                          error.what());
    }
    planning.renderer = renderer ? &*renderer : nullptr;
    const InstrumentJob job = prepare(simulation, *instrument, context, planning);
    if (context.common.dry_run) {
      auto item = dry_run_json(simulation.scene, job, settings,
                               renderer ? renderer->tuning().tile_samples : render::kTileSamples);
      if (renderer) item["estimated_s"] = estimate_render_s(*renderer, simulation, job);
      done.whole.push_back(std::move(item));
      continue;
    }
    done.whole.push_back(render_one(simulation, job, *renderer, cl::find_device(settings.device).info(),
                                    out / instrument->name, load_s, context));
  }
  for (const auto* lidar : lidars)
    done.whole.push_back(context.common.dry_run ? dry_run_lidar(simulation, *lidar, context, planning)
                                                : render_lidar(simulation, *lidar, (out / lidar->name).string(), load_s,
                                                               context, planning));
  if (context.common.json) {
    context.out << nlohmann::json{{"instruments", done.whole}}.dump(2) << "\n";
    return 0;
  }
  for (const auto& item : done.whole) {
    if (context.common.dry_run)
      context.out << (item.contains("kind") ? dry_run_lidar_text(item) : dry_run_text(item));
    else
      context.out << item[item.contains("cube") ? "cube" : "main"].get<std::string>() << "\n";
  }
  return 0;
}

/// An error that comes after some instruments are whole says that they stay, and how to go on.
int run_and_keep(const Options& options, Context& context) {
  Done done;
  try {
    return run(options, context, done);
  } catch (const base::Error& error) {
    if (context.common.dry_run || done.whole.empty() || done.whole.size() == done.names.size()) throw;
    std::string kept, rest;
    for (const auto& item : done.whole) kept += (kept.empty() ? "" : ", ") + item["folder"].get<std::string>();
    for (std::size_t i = done.whole.size(); i < done.names.size(); ++i)
      rest += (rest.empty() ? "--instrument " : ", then --instrument ") + done.names[i];
    throw base::Error(error.fault(), std::string(error.what()) + "; whole and kept: " + kept + "; go on with " + rest);
  }
}

}  // namespace

Verb verb_render() {
  auto options = std::make_shared<Options>();
  Verb verb;
  verb.name = "render";
  verb.summary = "Render the instruments of a simulation file into radiance cubes with truth";
  verb.description =
      "Each instrument gets a folder of its own under the output folder: radiance.img (ENVI), truth.img, "
      "location.img when the "
      "scene is georeferenced (with map info in every header when the pixels lie on a map grid), "
      "preview.exr, quicklook.png and run.json. Files appear under these names only when all of them are "
      "whole, and as one: `raycube info --verify` holds them against the hashes in run.json. Instruments "
      "that are whole stay when a later one fails.\n\nSamples, sky directions and sub-rays that the file "
      "does not give are chosen by the tolerance (see `raycube plan`); "
      "run.json holds every line of the plan.\n\nThe result on stdout is the path of each cube, one a line.";
  verb.examples = {"raycube render park.toml -o out",
                   "raycube render park.toml --instrument spectir --memory 1G --overwrite"};
  verb.common = kOutput | kDryRun | kCompute;
  verb.output_default = "out";
  verb.add_options = [options](base::OptionTable& table) {
    table.argument("FILE", "The simulation file (TOML)", options->file);
    table.text("--instrument", "NAME", "Only this instrument", options->instrument);
    table.text("--plan", "FILE", "Replay a plan that `raycube plan -o FILE` wrote, instead of planning", options->plan);
  };
  verb.run = [options](Context& context) { return run_and_keep(*options, context); };
  return verb;
}

}  // namespace raycube::cli
