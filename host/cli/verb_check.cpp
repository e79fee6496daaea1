// `raycube check`: the device against the reference, on pixels picked by hash.
#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <ostream>

#include <nlohmann/json.hpp>

#include "host/base/output_file.h"
#include "host/run/check_instrument.h"
#include "host/run/check_lidar.h"
#include "host/run/difference_chart.h"
#include "host/run/input_check.h"
#include "host/run/lidar_job.h"
#include "host/cli/services.h"
#include "host/run/camera_job.h"
#include "host/run/load_job.h"
#include "host/cli/verb.h"
#include "host/planner/plan_lines.h"
#include "host/products/png_writer.h"

namespace raycube::cli {
namespace {

struct CheckRequest {
  std::string file, instrument;
  std::uint64_t rays = 10000000, pixels = 500, model_pixels = 64, pulses = 0;
  int model_directions = 1024;
};

std::vector<std::string> band_names(const scene::Instrument& instrument) {
  std::vector<std::string> names;
  for (std::size_t b = 0; b < instrument.bands.size(); ++b) {
    const scene::Band& band = instrument.bands[b];
    char text[64];
    std::snprintf(text, sizeof text, "%zu (%.1f nm)", b + 1, 1000 * band.center_um);
    names.push_back(band.center_um > 0 ? text : band.name);
  }
  return names;
}

/// What is written of one instrument. Both files are begun before anything is traced: what must not be replaced is
/// known then.
struct CheckFiles {
  CheckFiles(const std::string& folder, base::IfExists if_exists)
      : set(folder, if_exists), picture(set.add("difference.png")), json(set.add("check.json")) {}
  base::OutputSet set;
  base::OutputFile &picture, &json;

  /// all: the report as JSON, with what was looked at beside it.
  void write(const scene::Instrument& instrument, const reference::Report& report, const nlohmann::ordered_json& all) {
    const products::Raster chart = run::difference_chart(report, instrument);
    products::write_png(picture, static_cast<std::uint32_t>(chart.width()), static_cast<std::uint32_t>(chart.height()),
                        3, chart.rgb(),
                        {{"Description",
                          "relative difference of device and reference: columns bands, rows pixels in order of "
                          "line and sample; black 1e-9, blue 1e-8, green 1e-7, yellow 1e-6, red 2e-5 and more"}});
    json.append(all.dump(2) + "\n");
    set.publish();
  }
};

/// One report of a LIDAR, begun before anything is traced.
struct LidarFiles {
  LidarFiles(const std::string& folder, base::IfExists if_exists)
      : set(folder, if_exists), json(set.add("check.json")) {}
  base::OutputSet set;
  base::OutputFile& json;
};

/// Sums of a run over all instruments.
struct Outcome {
  bool passed = true;
  nlohmann::ordered_json all;
};

/// What no comparison of an instrument can see: both sides trace the same rays of the same scene.
std::vector<std::string> not_looked_at(const run::CameraJob& job) {
  const planner::Decision& d = job.decision;
  const int samples = job.instrument->all_samples();
  std::string error = "how well " + std::to_string(samples) + (samples == 1 ? " sample tells" : " samples tell") +
                      " what a pixel holds, since both sides trace the same ones: ";
  if (d.samples_error >= 0)
    error += "the plan's trial says " + planner::percent_text(d.samples_error) + " of " +
             planner::percent_text(d.tolerance) + (d.within ? "" : ", and that the tolerance is NOT KEPT");
  else
    error += "`raycube plan` estimates it, `raycube render` says what its own samples show";
  std::vector<std::string> lines = {error};
  if (!d.small.missed.empty())
    lines.push_back(std::to_string(d.small.missed.size()) +
                    " objects with too few samples on them, which an rms over pixels does not see: the "
                    "warning above names them");
  if (job.instrument->adaptive())
    lines.push_back("which pixels the adaptive first pass settles: here all have all samples");
  if (job.plan.bounces.levels > 0 && job.plan.matter.plates)
    lines.push_back("the device's own paths, ray by ray: some go through plates, and only sums are compared");
  else if (job.plan.lamps.sources() > 0 && job.plan.bounces.levels > 0)
    lines.push_back("lamplight on the device's own paths, ray by ray: of that only sums are compared");
  return lines;
}

/// The same of a LIDAR.
std::vector<std::string> not_looked_at(const run::LidarJob& job) {
  const planner::LidarDecision& d = job.decision;
  std::string error = "how well " + std::to_string(d.subrays) + (d.subrays == 1 ? " sub-ray tells" : " sub-rays tell") +
                      " what a beam meets, since both sides trace the same ones: ";
  if (d.estimated)
    error += "the plan's trial says " + planner::percent_text(d.error) + " of " + planner::percent_text(d.tolerance) +
             (d.within ? "" : ", and that the tolerance is NOT KEPT");
  else
    error += "`raycube plan` estimates it, `raycube render` says what its own sub-rays show";
  std::vector<std::string> lines = {error,
                                    "what comes after the expected photons: background light, noise, the digitiser and "
                                    "the search for echoes"};
  if (job.lidar->turbulence.profile != scene::TurbulenceProfile::none)
    lines.emplace_back("turbulence: pulses are compared without it");
  return lines;
}

void check_one(const scene::Simulation& simulation, const scene::Instrument& given, render::Renderer& renderer,
               const CheckRequest& options, CheckFiles* files, Invocation& invocation, run::Services& services,
               Outcome& outcome) {
  run::Planning planning;
  planning.renderer = &renderer;
  const run::CameraJob job = run::prepare_camera(simulation, given, services, planning);
  const scene::Instrument& instrument = *job.instrument;
  run::CheckOptions check;
  check.pixels = options.pixels;
  check.model_pixels = options.model_pixels;
  check.model_directions = options.model_directions;
  check.threads = services.threads;
  const auto [report, small] = run::check_camera(renderer, simulation, job, check, options.rays, services);
  outcome.passed &= report.failures().empty();
  for (const auto& one : small) outcome.passed &= one.report.failures().empty();
  const std::vector<std::string> aside = not_looked_at(job);
  auto json = nlohmann::ordered_json::parse(report.json());
  for (const auto& one : small)
    json["small_objects"].push_back({{"samples_per_pixel", one.samples},
                                     {"pixels_of_the_image", one.pixels},
                                     {"report", nlohmann::ordered_json::parse(one.report.json())}});
  json["not_looked_at"] = aside;
  if (invocation.common.json) {
    outcome.all[instrument.name] = json;
  } else {
    invocation.out << "instrument " << instrument.name << " on " << renderer.device_name() << "\n"
                   << report.text(band_names(instrument));
    for (const auto& one : small)
      invocation.out << "pixels with small objects, " << one.samples << " samples each (" << one.pixels
                     << " of the image):\n"
                     << one.report.text(band_names(instrument));
    for (const std::string& line : aside) invocation.out << "not looked at: " << line << "\n";
  }
  if (!files) return;
  files->write(instrument, report, json);
  invocation.log.info("wrote " + files->set.folder() + "/check.json and difference.png");
}

void check_one_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, render::LidarRenderer& renderer,
                     const CheckRequest& options, LidarFiles* files, Invocation& invocation, run::Services& services,
                     Outcome& outcome) {
  run::LidarPlanning planning;
  planning.renderer = &renderer;
  const run::LidarJob job = run::prepare_lidar(simulation, lidar, services, planning);
  run::LidarCheckOptions check;
  check.pulses = options.pulses > 0 ? options.pulses : run::default_pulses(job.plan);
  check.threads = services.threads;
  const reference::LidarReport report = run::check_survey(renderer, simulation, job, check, services);
  outcome.passed &= report.failures().empty();
  const std::vector<std::string> aside = not_looked_at(job);
  auto json = nlohmann::ordered_json::parse(report.json());
  json["not_looked_at"] = aside;
  if (invocation.common.json) {
    outcome.all[lidar.name] = json;
  } else {
    invocation.out << "LIDAR " << lidar.name << " on " << renderer.device_name() << "\n" << report.text();
    for (const std::string& line : aside) invocation.out << "not looked at: " << line << "\n";
  }
  if (!files) return;
  files->json.append(json.dump(2) + "\n");
  files->set.publish();
  invocation.log.info("wrote " + files->set.folder() + "/check.json");
}

int run(Invocation& invocation, const CheckRequest& options) {
  run::Services services = services_of(invocation);
  const scene::Simulation simulation =
      run::load_job(options.file, invocation.common.seed, services, invocation.common.set);
  const auto lidars = run::pick_lidars(simulation, options.instrument);
  std::vector<const scene::Instrument*> instruments;
  if (lidars.empty())
    instruments = run::pick_instruments(simulation, options.instrument);
  else
    for (const scene::Instrument& instrument : simulation.instruments)
      if (options.instrument.empty() || instrument.name == options.instrument) instruments.push_back(&instrument);
  std::map<std::string, CheckFiles> files;
  std::map<std::string, LidarFiles> lidar_files;
  if (!invocation.common.output.empty()) {
    const base::IfExists if_exists = cli::if_exists(invocation.common);
    for (const scene::Instrument* instrument : instruments)
      files.try_emplace(instrument->name, invocation.common.output + "/" + instrument->name + "_check", if_exists);
    for (const scene::Lidar* lidar : lidars)
      lidar_files.try_emplace(lidar->name, invocation.common.output + "/" + lidar->name + "_check", if_exists);
  }
  run::check_inputs(simulation, {.instruments = instruments, .lidars = lidars});
  Outcome outcome;
  if (!instruments.empty()) {
    render::Renderer renderer(simulation.scene, render_options(invocation.common));
    for (const scene::Instrument* instrument : instruments) {
      const auto at = files.find(instrument->name);
      check_one(simulation, *instrument, renderer, options, at == files.end() ? nullptr : &at->second, invocation,
                services, outcome);
    }
  }
  if (!lidars.empty()) {
    render::LidarRenderer renderer(simulation.scene, render_options(invocation.common));
    for (const scene::Lidar* lidar : lidars) {
      const auto at = lidar_files.find(lidar->name);
      check_one_lidar(simulation, *lidar, renderer, options, at == lidar_files.end() ? nullptr : &at->second,
                      invocation, services, outcome);
    }
  }
  if (invocation.common.json)
    invocation.out << outcome.all.dump(2) << "\n";
  else
    invocation.out << (outcome.passed ? "check: within limits\n" : "check: BEYOND LIMITS\n");
  return outcome.passed ? 0 : 1;
}

}  // namespace

Verb verb_check() {
  auto o = std::make_shared<CheckRequest>();
  Verb verb("check", "Compare rendered pixels and pulses with the Embree and double precision reference");
  verb.description =
      "Pixels are picked by a hash of the seed. Both sides trace the very same fp32 rays.\n\n"
      "First hits, of many rays (--rays): those on which device and Embree differ are retraced in double and "
      "explained only "
      "when an edge or a depth lies within the stated error bound; counted by class. None may be "
      "unexplained. For every ray "
      "double also says whether it hits at all. The rest compares fewer pixels (--pixels) in full, sun and "
      "sky rays included.\n\n"
      "Arithmetic: the reference sums the plan's spectra per sample and wavelength in double; every band's "
      "median difference "
      "stays below 1e-6 and every difference below 2e-5.\n\n"
      "Model: the reference uses the whole tables and 1024 sky directions; the difference stays within the "
      "file's tolerance.\n\n"
      "Light between surfaces: sums over up to 256 pixels against paths of the reference's own, by their standard "
      "errors; and the device's own paths on up to 64, ray by ray, where none go through plates: no ray may be "
      "unexplained, no decision another than its draw's, and what the paths bring is held to 2e-5 at the wavelengths "
      "along them.\n\n"
      "Pixels whose small objects have them rendered with more samples are compared with those samples too. "
      "What no comparison sees, since both "
      "sides trace the same rays, is said at the end: above all how well a pixel's samples tell what it "
      "holds.\n\n"
      "LIDARs: the waveforms of --pulses pulses, without turbulence. Every bin stays within 1e-5 of its "
      "pulse's peak bin where both sides follow "
      "the same rays; rays that differ are explained like first hits. Light scattered more than once is also "
      "compared on other random "
      "draws, by its energy and by chi-square. The return of air and particles, which the device integrates "
      "along the beam, stays within 1 % of its own peak bin, "
      "5 % where surfaces end it, and what the number of sub-rays leaves open where the field's edge cuts "
      "the beam.\n\n"
      "With -o DIR, DIR/INSTRUMENT_check/ gets check.json and, for cubes, difference.png. Beyond a limit the "
      "exit status is 1.";
  verb.examples = {"raycube check park.toml", "raycube check park.toml --instrument spectir --pixels 2000 -o out"};
  verb.common = kOutput | kCompute | kSet;
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A simulation file", o->file);
    table.integer<std::uint64_t>(
        "--rays", "", 0, 1000000000000,
        "First hits of each instrument to compare, rounded up to groups of 4 pixels, at most the image's; "
        "1e6 a second and more on 2 cores; 0: those of --pixels only",
        o->rays);
    table.integer<std::uint64_t>("--pixels", "", 1, 1000000000,
                                 "Pixels of each instrument to compare in full, rounded up to groups of 4", o->pixels);
    table.integer<std::uint64_t>(
        "--pulses", "", 0, 1000000000,
        "Pulses of each LIDAR to compare; 0: 100, fewer where those have more than 3e5 rays, but 2", o->pulses);
    table.text("--instrument", "NAME", "Only this instrument or LIDAR", o->instrument);
    table.integer<std::uint64_t>("--model-pixels", "", 0, 1000000, "How many of them also meet the whole tables",
                                 o->model_pixels);
    table.integer<int>("--model-directions", "", 16, 65536, "Sky directions of that comparison", o->model_directions);
  };
  verb.run = [o](Invocation& invocation) { return run(invocation, *o); };
  return verb;
}

}  // namespace raycube::cli
