#include "host/planner/plan_file.h"

#include <cstdint>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/json_text.h"
#include "host/base/text.h"
#include "host/plan/sky_rays.h"
#include "host/planner/plan_lines.h"
#include "host/planner/replicated.h"
#include "host/planner/sample_pattern.h"

namespace raycube::planner {

namespace {

using Json = nlohmann::json;
constexpr int kVersion = 3, kFirstVersion = 2;  ///< what is written; what is read too: one path for two directions

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw base::Error(base::Fault::input, path + ": " + what + "; make the plan anew: raycube plan SIM -o " + path);
}

/// Error(input): the simulation's own `key` is not what the plan has.
[[noreturn]] void conflict(const std::string& path, const std::string& name, const std::string& key,
                           const std::string& given, const std::string& planned) {
  throw base::Error(base::Fault::input,
                    fmt::format("{}: '{}': the plan has {}, the simulation gives {} = {}; remove {} from the "
                                "simulation, or make the plan anew: raycube plan SIM -o {}",
                                path, name, planned, key, given, key, path));
}

double mean_of(const std::vector<std::vector<double>>& spectra) {
  double sum = 0, count = 0;
  for (const auto& spectrum : spectra)
    for (const double value : spectrum) sum += value, ++count;
  return count > 0 ? sum / count : 0;
}

}  // namespace

nlohmann::json axes_json(const plan::Plan& plan) {
  return Json{
      {"height_nodes", plan.height.count},
      {"view_nodes", plan.view.count},
      {"path_x_nodes", plan.path_x.count},
      {"path_y_nodes", plan.path_y.count},
      {"sun_sources", plan.sun_sources},
      {"sky_components", plan.sky_components},
      {"thermal_sky_components", plan.thermal.sky_components},
      {"temperature_nodes", plan.thermal.nodes()},
      {"environment_nodes", plan.environment.nodes()},
      {"wavelengths", plan.wavelength_um.size()},
      {"bands", plan.bands.size()},
      {"bounces", plan.bounces.levels},
      {"sun", fmt::format("{:.5f} {:.5f} {:.5f}", plan.sun_direction[0], plan.sun_direction[1], plan.sun_direction[2])},
      {"light", fmt::format("{:.4g} {:.4g}", mean_of(plan.source_spectrum), mean_of(plan.path_spectrum))}};
}

std::string write_plan_file(const PlanFile& file) {
  Json list = Json::array();
  for (const auto& entry : file.entries) {
    Json item = {{"name", entry.name}, {"kind", entry.lidar ? "lidar" : "instrument"}, {"decision", entry.decision}};
    if (entry.lidar)
      item["subrays"] = entry.subrays;
    else
      item["sampler"] = static_cast<int>(entry.sampling.sampler),
      item["samples"] = {entry.sampling.samples_u, entry.sampling.samples_v},
      item["sky_directions"] = entry.sampling.directions, item["replicates"] = entry.sampling.replicates,
      item["paths_per_two_directions"] = entry.sampling.paths_per_two, item["plan"] = entry.axes;
    list.push_back(std::move(item));
  }
  return Json{{"raycube_plan", kVersion},
              {"simulation", file.simulation_file},
              {"scene_hash", file.scene_hash},
              {"tolerance", file.tolerance},
              {"tolerance_of", figure_name(file.tolerance_of.figure)},
              {"tolerance_materials", file.tolerance_of.materials},
              {"seed", file.seed},
              {"instruments", list}}
             .dump(2) +
         "\n";
}

namespace {

/// Of plans that do not say the rms over all pixels.
scene::ToleranceMeasure measure_in(const Json& root, const std::string& path) {
  try {
    return {scene::figure_named(root.value("tolerance_of", "rms")),
            root.value("tolerance_materials", std::vector<std::string>())};
  } catch (const std::invalid_argument& unknown) {
    refuse(path, std::string(unknown.what()) + "; there are rms, p99 and worst");
  }
}

}  // namespace

PlanFile read_plan_file(const std::string& path) {
  base::refuse_other_than_plain(path);
  std::ifstream in(path);
  if (!in)
    throw base::Error(base::Fault::input, path + ": the plan cannot be read; `raycube plan SIM -o FILE` writes one");
  PlanFile file;
  try {
    const Json root = Json::parse(base::shallow_json(in));
    if (const int version = root.at("raycube_plan").get<int>(); version < kFirstVersion || version > kVersion)
      refuse(path, fmt::format("version {} of the plan's format, this program reads {}",
                               root.at("raycube_plan").get<int>(), kVersion));
    file.simulation_file = root.at("simulation").get<std::string>();
    file.scene_hash = root.at("scene_hash").get<std::string>();
    file.tolerance = root.at("tolerance").get<double>();
    file.tolerance_of = measure_in(root, path);
    file.seed = root.at("seed").get<std::uint64_t>();
    for (const auto& item : root.at("instruments")) {
      PlanFile::Entry entry;
      entry.name = item.at("name").get<std::string>();
      entry.lidar = item.at("kind").get<std::string>() == "lidar";
      entry.decision = item.at("decision");
      if (entry.lidar) {
        entry.subrays = item.at("subrays").get<int>();
        if (entry.subrays < 1 || entry.subrays > 65536)
          refuse(path, fmt::format("'{}': subrays {} are not in 1 to 65536", entry.name, entry.subrays));
      } else {
        const int sampler = item.at("sampler").get<int>();
        entry.sampling = {static_cast<scene::SamplerKind>(sampler), item.at("samples").at(0).get<int>(),
                          item.at("samples").at(1).get<int>(), item.at("sky_directions").get<int>(),
                          item.value("replicates", 1)};
        entry.sampling.paths_per_two = item.value("paths_per_two_directions", 1);
        if (entry.sampling.paths_per_two < 1 || entry.sampling.paths_per_two > kMostPathsPerTwo)
          refuse(path, fmt::format("'{}': paths_per_two_directions {} are not in 1 to {}", entry.name,
                                   entry.sampling.paths_per_two, kMostPathsPerTwo));
        entry.axes = item.at("plan");
        const auto& s = entry.sampling;
        const bool lattice = s.sampler == scene::SamplerKind::lattice;
        const int most_u = lattice ? kMostSamples : kMostSide, most_v = kMostSide;
        if (sampler < 0 || sampler > 2 || s.samples_u < 1 || s.samples_u > most_u || s.samples_v < 1 ||
            s.samples_v > most_v || std::int64_t{s.samples_u} * s.samples_v > kMostSamples || s.directions < 1 ||
            s.directions > plan::kMostSkyRays || s.replicates < 1 || s.replicates > kMostReplicates)
          refuse(path, fmt::format("'{}': samples {} x {}, {} sky directions or {} replicates are out of range",
                                   entry.name, s.samples_u, s.samples_v, s.directions, s.replicates));
      }
      file.entries.push_back(std::move(entry));
    }
  } catch (const Json::exception& error) {
    refuse(path, std::string("not a plan of raycube: ") + error.what());
  }
  return file;
}

std::vector<std::string> changes_since(const PlanFile& file, const scene::Simulation& simulation) {
  std::vector<std::string> out;
  if (file.scene_hash != simulation.scene.content_hash)
    out.push_back("another scene (" + file.simulation_file + "), or the scene has changed since");
  if (file.tolerance != simulation.tolerance)
    out.push_back(fmt::format("a tolerance of {:g}, not {:g}", file.tolerance, simulation.tolerance));
  if (file.tolerance_of != simulation.tolerance_of)
    out.push_back(fmt::format("a tolerance of the {}, not of the {}", measure_text(file.tolerance_of),
                              measure_text(simulation.tolerance_of)));
  if (file.seed != simulation.seed) out.push_back(fmt::format("seed {}, not {}", file.seed, simulation.seed));
  return out;
}

const PlanFile::Entry& find_entry(const PlanFile& file, const std::string& name, bool lidar, const std::string& path) {
  std::string known;
  for (const auto& entry : file.entries) {
    if (entry.name == name && entry.lidar == lidar) return entry;
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  throw base::Error(base::Fault::input, path + ": the plan has no " + (lidar ? "LIDAR" : "instrument") + " '" + name +
                                            "'; there are: " + (known.empty() ? "none" : known));
}

namespace {

/// What the user must know of a plan that was made for something else.
std::string first_guess_note(const std::string& path, const std::string& name, const std::string& settings,
                             const std::vector<std::string>& changes) {
  std::string list;
  for (const std::string& change : changes) list += (list.empty() ? "" : "; ") + change;
  return fmt::format(
      "{}: '{}': the plan was made for {}: its {} are a first guess, whose error is measured when the run is done; for "
      "a "
      "plan of this one: raycube plan SIM -o {}",
      path, name, list, settings, path);
}

/// Error(input): what the plan has the simulation cannot have.
void require_applicable(const PlanFile::Entry& entry, const scene::Simulation& simulation,
                        const scene::Instrument& instrument, const plan::Plan& plan, const std::string& path) {
  const Sampling& s = entry.sampling;
  if (instrument.samples_given && (instrument.sampler != s.sampler || instrument.samples_u != s.samples_u ||
                                   instrument.samples_v != s.samples_v || s.replicates > 1))
    conflict(path, entry.name, "samples", sampler_text(instrument.sampler, instrument.samples_u, instrument.samples_v),
             sampling_text(s));
  if (s.replicates > 1 && (instrument.first_samples > 0 || instrument.standard_error != scene::StandardError::off))
    refuse(path, fmt::format("'{}': the plan has {}, which go with neither adaptive samples nor standard errors",
                             entry.name, sampling_text(s)));
  if (s.sampler == scene::SamplerKind::lattice && !instrument.box_pixels())
    refuse(path,
           fmt::format("'{}': the plan has {}, which does not go with a point spread", entry.name, sampling_text(s)));
  if (simulation.sky_directions_given && plan.sends_rays() && simulation.sky_directions != s.directions)
    conflict(path, entry.name, "sky_directions", std::to_string(simulation.sky_directions),
             std::to_string(s.directions) + " sky directions");
  const int given = scene::paths_beside(simulation.sky_directions, simulation.paths_per_two),
            planned = scene::paths_beside(s.directions, s.paths_per_two);
  if (simulation.sky_directions_given && plan.bounces.any() && given != planned)
    conflict(path, entry.name, simulation.paths_per_two > 1 ? "paths" : "sky_directions",
             simulation.paths_per_two > 1 ? std::to_string(given)
                                          : fmt::format("{}, {} paths", simulation.sky_directions, given),
             fmt::format("{} paths between surfaces", planned));
}

/// What the plan's trial found, for the scene that it was made for.
void take_findings(Decision& out, const Json& saved) {
  const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : -1.0; };
  out.plan_error = saved.at("error").at("plan").get<double>();
  if (saved.contains("model_pixels")) out.model_pixels = saved.at("model_pixels").get<std::size_t>();
  out.samples_error = number(saved.at("error").at("samples")),
  out.sky_error = number(saved.at("error").at("sky_directions"));
  out.total_error = number(saved.at("error").at("total"));
  out.within = !saved.at("within_tolerance").is_boolean() || saved.at("within_tolerance").get<bool>();
  out.estimated = saved.contains("trial");
  if (out.estimated)
    out.trial_pixels = saved.at("trial").at("pixels").get<std::size_t>(),
    out.trial_rays = saved.at("trial").at("rays").get<std::uint64_t>();
  for (const auto& note : saved.at("notes")) out.notes.push_back(note.get<std::string>());
  for (const auto& line : saved.at("lines")) {
    if (line.at("block") == "samples") out.samples_less_error = number(line.at("error_without"));
    if (line.at("block") == "sky directions") out.sky_less_error = number(line.at("error_without"));
  }
}

}  // namespace

Decision replayed(const PlanFile::Entry& entry, std::vector<std::string> changes, const scene::Simulation& simulation,
                  const scene::Instrument& instrument, const plan::Plan& plan, const std::string& path) {
  require_applicable(entry, simulation, instrument, plan, path);
  // The nodes depend on the scene too: named only where nothing else is.
  if (changes.empty() && entry.axes != axes_json(plan))
    changes.push_back(
        fmt::format("nodes and components, sun and light {}, not {}: sun, air, instrument or [plan] have changed since",
                    entry.axes.dump(), axes_json(plan).dump()));
  Decision out = as_given(simulation, instrument, plan);
  out.sampling = entry.sampling;
  out.sampling.first_samples = instrument.first_samples;
  count_cost(out, plan);
  try {
    if (changes.empty()) take_findings(out, entry.decision);
  } catch (const Json::exception& error) {
    refuse(path, std::string("not a plan of raycube: ") + error.what());
  }
  if (!changes.empty()) out.notes.push_back(first_guess_note(path, entry.name, "samples and sky directions", changes));
  return out;
}

LidarDecision replayed(const PlanFile::Entry& entry, const std::vector<std::string>& changes,
                       const lidar::LidarPlan& plan, double tolerance, const std::string& path) {
  LidarDecision out = subrays_as_given(plan, tolerance);
  if (out.given && out.subrays != entry.subrays)
    conflict(path, entry.name, "subrays", std::to_string(out.subrays), base::counted(entry.subrays, "sub-ray"));
  out.subrays = entry.subrays;
  out.rays_per_pulse = rays_of_pulse(plan, out.subrays);
  if (changes.empty() && entry.decision.contains("pulse_error") && entry.decision.at("pulse_error").is_number())
    out.pulse_error = entry.decision.at("pulse_error").get<double>();
  if (!changes.empty()) out.notes.push_back(first_guess_note(path, entry.name, "sub-rays", changes));
  return out;
}

}  // namespace raycube::planner
