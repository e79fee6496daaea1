// The planner's promises held against converged references and brute force, one JSON file for
// bench/planner_accuracy.py.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bench/planner_study.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/standard_streams.h"
#include "scene_compiler/load_simulation.h"

namespace {

using namespace raycube;
using nlohmann::json;

json to_json(const bench::SweepPoint& p) {
  return {{"setting", p.setting.text()},
          {"samples", p.setting.samples},
          {"directions", p.setting.directions},
          {"error", p.error},
          {"low", p.low},
          {"high", p.high},
          {"s_per_megapixel", p.s_per_megapixel}};
}

json to_json(const bench::PlannerRow& r) {
  json out = {{"tolerance", r.tolerance},
              {"setting", r.chosen.text()},
              {"samples", r.chosen.samples},
              {"directions", r.chosen.directions},
              {"replicates", r.chosen.replicates},
              {"claimed", r.claimed},
              {"nodes", r.plan_error},
              {"samples", r.samples_error},
              {"sky", r.sky_error},
              {"within", r.within},
              {"dear", r.dear},
              {"s_per_megapixel", r.s_per_megapixel},
              {"plan_s", r.plan_s},
              {"judged", r.judged}};
  if (r.tried) out.update({{"achieved", r.achieved}, {"low", r.low}, {"high", r.high}, {"own", r.own}});
  if (r.best_known) out.update({{"best", to_json(r.best)}, {"cost_over_best", r.cost_over_best}});
  if (r.best_s >= 0) out.update({{"together_s", r.together_s}, {"best_s", r.best_s}});
  if (r.time_over_best.count > 0)
    out.update({{"time_over_best", r.time_over_best.median},
                {"time_over_best_min", r.time_over_best.lowest},
                {"time_over_best_max", r.time_over_best.highest}});
  return out;
}

json to_json(const bench::PlannerStudy& s) {
  json rows = json::array(), points = json::array();
  for (const auto& row : s.rows) rows.push_back(to_json(row));
  for (const auto& point : s.points) points.push_back(to_json(point));
  return {{"scene", s.scene},         {"instrument", s.instrument}, {"kind", s.kind},     {"device", s.device},
          {"reference", s.reference}, {"sweep", s.sweep},           {"pixels", s.pixels}, {"own", s.own},
          {"seconds", s.seconds},     {"points", points},           {"rows", rows}};
}

int study_all(const std::string& file, const std::vector<std::string>& scenes, const std::string& only,
              const bench::PlannerStudySettings& settings) {
  base::Log log;
  run::Services services = run::watched_services(log);
  json all = json::array();
  const auto keep = [&](const bench::PlannerStudy& study) {
    all.push_back(to_json(study));
    std::ofstream out(file);
    out << json{{"cases", all}}.dump(1) << "\n";
    if (!out.good()) throw base::Error(base::Fault::environment, file + ": cannot be written");
  };
  for (const std::string& scene : scenes) {
    const auto equals = scene.find('=');
    const std::string name = scene.substr(0, equals), path = scene.substr(equals + 1);
    scene::Simulation simulation = scene::load_simulation(path);
    simulation.bounces = 0, simulation.bounces_given = true;  // the converged solution is of light scattered once
    for (std::size_t i = 0; i < simulation.instruments.size(); ++i)
      if (only.empty() || simulation.instruments[i].name == only)
        keep(bench::study_instrument(simulation, i, name, settings, services));
    for (std::size_t i = 0; i < simulation.lidars.size(); ++i)
      if (only.empty() || simulation.lidars[i].name == only)
        keep(bench::study_lidar(simulation, i, name, settings, services));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  raycube::base::claim_standard_descriptors();
  CLI::App app("The planner's decisions against converged references and a sweep of settings.");
  std::string file, only;
  std::vector<std::string> scenes;
  bench::PlannerStudySettings settings;
  app.add_option("--json", file, "File for the figures")->required();
  app.add_option("--only", only, "One instrument or LIDAR");
  app.add_option("--tolerances", settings.tolerances, "Asked of the planner")->delimiter(',');
  app.add_option("--reference-s", settings.reference_s, "Nominal seconds for a reference")->capture_default_str();
  app.add_option("scenes", scenes, "NAME=FILE of each scene")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    return study_all(file, scenes, only, settings);
  } catch (const base::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
}
