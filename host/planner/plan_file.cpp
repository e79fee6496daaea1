#include "host/planner/plan_file.h"

#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"

namespace raycube::planner {

namespace {

using Json = nlohmann::json;
constexpr int kVersion = 1;

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw base::Error(base::Fault::input, path + ": " + what + "; make the plan anew: raycube plan SIM -o " + path);
}

}  // namespace

std::string axes_json(const plan::Plan& plan) {
  return Json{{"height_nodes", plan.height.count},
              {"view_nodes", plan.view.count},
              {"path_x_nodes", plan.path_x.count},
              {"path_y_nodes", plan.path_y.count},
              {"sun_sources", plan.sun_sources},
              {"sky_components", plan.sky_components},
              {"thermal_sky_components", plan.thermal.sky_components},
              {"temperature_nodes", plan.thermal.nodes()},
              {"environment_nodes", plan.environment.nodes()},
              {"wavelengths", plan.wavelength_um.size()},
              {"bands", plan.bands.size()}}
      .dump();
}

std::string write_plan_file(const PlanFile& file) {
  Json list = Json::array();
  for (const auto& entry : file.entries) {
    Json item = {{"name", entry.name}, {"kind", entry.lidar ? "lidar" : "instrument"}, {"decision", Json::parse(entry.decision)}};
    if (entry.lidar)
      item["subrays"] = entry.subrays;
    else
      item["sampler"] = static_cast<int>(entry.sampling.sampler), item["samples"] = {entry.sampling.samples_u, entry.sampling.samples_v},
      item["sky_directions"] = entry.sampling.directions, item["plan"] = Json::parse(entry.axes);
    list.push_back(std::move(item));
  }
  return Json{{"raycube_plan", kVersion}, {"simulation", file.simulation_file}, {"scene_hash", file.scene_hash}, {"tolerance", file.tolerance}, {"seed", file.seed}, {"instruments", list}}
             .dump(2) +
         "\n";
}

PlanFile read_plan_file(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw base::Error(base::Fault::input, path + ": the plan cannot be read; `raycube plan SIM -o FILE` writes one");
  std::ostringstream text;
  text << in.rdbuf();
  PlanFile file;
  try {
    const Json root = Json::parse(text.str());
    if (root.at("raycube_plan").get<int>() != kVersion) refuse(path, fmt::format("version {} of the plan's format, this program reads {}", root.at("raycube_plan").get<int>(), kVersion));
    file.simulation_file = root.at("simulation").get<std::string>();
    file.scene_hash = root.at("scene_hash").get<std::string>();
    file.tolerance = root.at("tolerance").get<double>();
    file.seed = root.at("seed").get<std::uint64_t>();
    for (const auto& item : root.at("instruments")) {
      PlanFile::Entry entry;
      entry.name = item.at("name").get<std::string>();
      entry.lidar = item.at("kind").get<std::string>() == "lidar";
      entry.decision = item.at("decision").dump();
      if (entry.lidar) {
        entry.subrays = item.at("subrays").get<int>();
        if (entry.subrays < 1 || entry.subrays > 65536) refuse(path, fmt::format("'{}': subrays {} are not in 1 to 65536", entry.name, entry.subrays));
      } else {
        const int sampler = item.at("sampler").get<int>();
        entry.sampling = {static_cast<scene::SamplerKind>(sampler), item.at("samples").at(0).get<int>(), item.at("samples").at(1).get<int>(), item.at("sky_directions").get<int>()};
        entry.axes = item.at("plan").dump();
        const auto& s = entry.sampling;
        if (sampler < 0 || sampler > 2 || s.samples_u < 1 || s.samples_u > 65536 || s.samples_v < 1 || s.samples_v > 256 || s.directions < 1 || s.directions > 4096)
          refuse(path, fmt::format("'{}': samples {} x {} or {} sky directions are out of range", entry.name, s.samples_u, s.samples_v, s.directions));
      }
      file.entries.push_back(std::move(entry));
    }
  } catch (const Json::exception& error) {
    refuse(path, std::string("not a plan of raycube: ") + error.what());
  }
  return file;
}

void require_match(const PlanFile& file, const scene::Simulation& simulation, const std::string& path) {
  if (file.scene_hash != simulation.scene.content_hash) refuse(path, "the plan was made for another scene (" + file.simulation_file + "), or the scene has changed since");
  if (file.tolerance != simulation.tolerance) refuse(path, fmt::format("the plan was made for a tolerance of {:g}, the simulation has {:g}", file.tolerance, simulation.tolerance));
  if (file.seed != simulation.seed) refuse(path, fmt::format("the plan was made with seed {}, the simulation has {}", file.seed, simulation.seed));
}

const PlanFile::Entry& find_entry(const PlanFile& file, const std::string& name, bool lidar, const std::string& path) {
  std::string known;
  for (const auto& entry : file.entries) {
    if (entry.name == name && entry.lidar == lidar) return entry;
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  throw base::Error(base::Fault::input, path + ": the plan has no " + (lidar ? "LIDAR" : "instrument") + " '" + name + "'; there are: " + (known.empty() ? "none" : known));
}

Decision replayed(const PlanFile::Entry& entry, const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan, const std::string& path) {
  if (Json::parse(entry.axes) != Json::parse(axes_json(plan)))
    refuse(path, fmt::format("'{}': the plan has {}, the simulation as it is now needs {}: air, instrument or [plan] have changed since", entry.name, entry.axes, axes_json(plan)));
  const Json saved = Json::parse(entry.decision);
  Decision out = as_given(simulation, instrument, plan);
  out.sampling = entry.sampling;
  out.sampling.first_samples = instrument.first_samples;
  out.counts = pixel_counts(plan, static_cast<double>(entry.sampling.samples_u) * entry.sampling.samples_v, entry.sampling.directions);
  out.s_per_megapixel = 1e6 * CostModel().seconds(out.counts);
  const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : -1.0; };
  try {
    out.samples_error = number(saved.at("error").at("samples")), out.sky_error = number(saved.at("error").at("sky_directions"));
    out.total_error = number(saved.at("error").at("total"));
    out.within = !saved.at("within_tolerance").is_boolean() || saved.at("within_tolerance").get<bool>();
    out.estimated = saved.contains("trial");
    if (out.estimated) out.trial_pixels = saved.at("trial").at("pixels").get<std::size_t>(), out.trial_rays = saved.at("trial").at("rays").get<std::uint64_t>();
    for (const auto& note : saved.at("notes")) out.notes.push_back(note.get<std::string>());
    for (const auto& line : saved.at("lines")) {
      if (line.at("block") == "samples") out.samples_less_error = number(line.at("error_without"));
      if (line.at("block") == "sky directions") out.sky_less_error = number(line.at("error_without"));
    }
  } catch (const Json::exception& error) {
    refuse(path, std::string("not a plan of raycube: ") + error.what());
  }
  out.dear = out.s_per_megapixel > kDear_s_per_megapixel;
  return out;
}

}  // namespace raycube::planner
