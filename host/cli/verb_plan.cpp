// raycube plan: what each block of the physics costs and leaves out for the tolerance, and the settings that render
// will use.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/output_file.h"
#include "host/base/text.h"
#include "host/run/input_check.h"
#include "host/run/lidar_job.h"
#include "host/cli/services.h"
#include "host/run/camera_job.h"
#include "host/run/load_job.h"
#include "host/planner/plan_file.h"
#include "host/planner/plan_lines.h"
#include "host/planner/seconds_text.h"

namespace raycube::cli {

namespace {

struct PlanRequest {
  std::string file, instrument;
};

/// Everything said of one instrument or LIDAR.
struct Said {
  std::string heading, table, summary;
  planner::PlanFile::Entry entry;
  std::vector<std::string> notes;
};

Said plan_instrument(const scene::Simulation& simulation, const scene::Instrument& instrument,
                     render::Renderer& renderer, run::Services& services) {
  run::Planning planning;
  planning.renderer = &renderer;
  planning.estimate_given = true;
  const run::CameraJob job = run::prepare_camera(simulation, instrument, services, planning);
  const planner::Decision& d = job.decision;
  const auto lines = planner::plan_lines(d, job.plan);
  Said said;
  said.heading = fmt::format("{}: {} x {} pixels, {}, tolerance {:.3g} % ({})\n", instrument.name, instrument.pixels,
                             instrument.lines, base::counted(instrument.bands.size(), "band"),
                             100 * simulation.tolerance, measure_text(simulation.tolerance_of));
  said.table = planner::lines_text(lines);
  said.summary = fmt::format(
      "  estimated error {} of {:.3g} %: nodes and components {}{}, {}, each of its own worst band; {}\n"
      "  cost            {:.0f} rays, {:.0f} terms of {:.0f} bands a pixel; {} s per megapixel on the nominal "
      "machine\n"
      "  trial           {}, {} rays\n",
      planner::percent_text(d.total_error), 100 * simulation.tolerance, planner::percent_text(d.plan_error),
      d.model_pixels > 0
          ? fmt::format(" (on {} against the whole tables; in the table above {} for the worst place and obstacle)",
                        base::counted(static_cast<std::size_t>(d.model_pixels), "pixel"),
                        planner::percent_text(d.plan_estimate))
          : "",
      planner::drawn_text(d), d.within ? "inside the tolerance" : "TOLERANCE NOT KEPT", d.counts.rays(), d.counts.terms,
      d.counts.bands, planner::seconds_text(d.s_per_megapixel),
      base::counted(static_cast<std::size_t>(d.trial_pixels), "pixel"),
      base::about_count(static_cast<double>(d.trial_rays)));
  said.entry = {instrument.name, false, d.sampling, 0, planner::axes_json(job.plan), planner::decision_json(d, lines)};
  said.notes = d.notes;
  return said;
}

Said plan_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, render::LidarRenderer& renderer,
                run::Services& services) {
  const run::LidarJob job = run::prepare_lidar(simulation, lidar, services, {&renderer, nullptr, "", true});
  const planner::LidarDecision& d = job.decision;
  Said said;
  said.heading =
      fmt::format("{}: {}, tolerance {:.3g} % of the waveforms\n", lidar.name,
                  base::counted(static_cast<std::size_t>(lidar.pulses), "pulse"), 100 * simulation.tolerance);
  said.table = planner::lines_text(planner::lidar_lines(d, job.plan));
  said.summary = fmt::format("  estimated error {}, {}\n  trial           {}, {} rays\n",
                             planner::percent_text(d.error), d.within ? "inside the tolerance" : "TOLERANCE NOT KEPT",
                             base::counted(static_cast<std::size_t>(d.trial_pulses), "pulse"),
                             base::about_count(static_cast<double>(d.trial_rays)));
  said.entry.name = lidar.name, said.entry.lidar = true, said.entry.subrays = d.subrays,
  said.entry.decision = run::plan_json(job);
  said.notes = d.notes;
  return said;
}

int run(const PlanRequest& options, Invocation& invocation) {
  run::Services services = services_of(invocation);
  const scene::Simulation simulation =
      run::load_job(options.file, invocation.common.seed, services, invocation.common.set);
  const auto instruments = run::pick_instruments(simulation, options.instrument);
  const auto lidars = run::pick_lidars(simulation, options.instrument);
  const auto settings = render_options(invocation.common);
  std::optional<base::OutputFile> output;
  if (!invocation.common.output.empty()) output.emplace(invocation.common.output, if_exists(invocation.common));
  run::check_inputs(simulation, {.instruments = instruments, .lidars = lidars, .background = true});
  std::vector<Said> all;
  if (!instruments.empty()) {
    render::Renderer renderer(simulation.scene, settings);
    for (const auto* instrument : instruments)
      all.push_back(plan_instrument(simulation, *instrument, renderer, services));
  }
  if (!lidars.empty()) {
    render::LidarRenderer renderer(simulation.scene, settings);
    for (const auto* lidar : lidars) all.push_back(plan_lidar(simulation, *lidar, renderer, services));
  }
  planner::PlanFile file{simulation.file,      simulation.scene.content_hash,
                         simulation.tolerance, simulation.tolerance_of,
                         simulation.seed,      {}};
  for (const auto& said : all) file.entries.push_back(said.entry);
  const std::string text = planner::write_plan_file(file);
  if (invocation.common.json) {
    invocation.out << text;
  } else {
    for (const auto& said : all) invocation.out << said.heading << said.table << said.summary;
    invocation.out << "Errors are of the numerics and of levels left out, against the converged solution of the same "
                      "scene and air; input data are not judged.\n";
  }
  if (output) {
    output->append(text);
    output->publish();
    invocation.log.info("wrote " + invocation.common.output);
  }
  return 0;
}

}  // namespace

Verb verb_plan() {
  auto options = std::make_shared<PlanRequest>();
  Verb verb("plan", "Say what each block of the physics costs and which levels keep the tolerance");
  verb.description =
      "For each instrument a table: block, level chosen, its estimated error, the error without it (with the level "
      "before), its cost, and why. "
      "Errors are those of the tolerance: rms over the pixels of the worst band over that band's mean, or the "
      "figure and the pixels that tolerance_of and tolerance_materials ask for. Levels that the "
      "file gives are kept and "
      "marked; the rest are the cheapest whose errors together fit the tolerance, by counts of rays, terms and bands "
      "and never by a clock: two runs give "
      "one plan.\n\nSamples of a pixel and sky directions are tried on a few hundred pixels picked by a hash of the "
      "seed (all of a small image); sub-rays of LIDARs on a few "
      "pulses. Where the tolerance cannot be kept, or only at more than 30 s per megapixel, the plan says so.\n\nWith "
      "-o FILE the plan "
      "is written as JSON, which `raycube render --plan FILE` replays.";
  verb.examples = {"raycube plan park.toml", "raycube plan park.toml --instrument wasp -o wasp_plan.json"};
  verb.common = kOutput | kCompute | kSet;
  verb.add_options = [options](base::OptionTable& table) {
    table.argument("FILE", "The simulation file (TOML)", options->file);
    table.text("--instrument", "NAME", "Only this instrument or LIDAR", options->instrument);
  };
  verb.run = [options](Invocation& invocation) { return run(*options, invocation); };
  return verb;
}

}  // namespace raycube::cli
