// `raycube scene`: look at a simulation's scene, check it, compile it, print its format.
#include <map>
#include <memory>
#include <ostream>

#include "host/base/error.h"
#include "host/base/text.h"
#include "host/run/air_limits.h"
#include "host/experiment/study_keys.h"
#include "host/run/input_check.h"
#include "host/cli/verb.h"
#include "scene_compiler/compiled_file.h"
#include "scene_compiler/load_simulation.h"
#include "scene_compiler/option_table.h"
#include "scene_compiler/scene_info.h"

namespace raycube::cli {
namespace {

struct SceneRequest {
  std::string file;
};

scene::Simulation load(Invocation& invocation, const std::string& file) {
  scene::LoadOptions options;
  options.overrides = invocation.common.set;  // of `check` alone
  auto simulation = scene::load_simulation(file, options);
  run::keep_within_air(simulation);
  for (const auto& notice : simulation.notices) invocation.log.warning(notice);
  return simulation;
}

bool is_compiled(const std::string& file) { return file.ends_with(".rcs"); }

void print_info(Invocation& invocation, const scene::CompiledScene& compiled) {
  const auto info = scene::scene_info(compiled);
  invocation.out << (invocation.common.json ? scene::scene_info_json(info) : scene::scene_info_text(info));
}

Verb verb_scene_info() {
  auto o = std::make_shared<SceneRequest>();
  Verb verb("info", "Count a scene's triangles, instances, bytes, materials");
  verb.examples = {"raycube scene info park.toml"};
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A simulation file, or a compiled scene (.rcs)", o->file);
  };
  verb.run = [o](Invocation& invocation) {
    print_info(invocation, is_compiled(o->file) ? scene::load_compiled(o->file) : load(invocation, o->file).scene);
    return 0;
  };
  return verb;
}

Verb verb_scene_check() {
  auto o = std::make_shared<SceneRequest>();
  Verb verb("check", "Validate a simulation file and all it names, report every problem at once");
  verb.description =
      "Whatever a render would refuse that needs neither the air computed nor a ray sent is told here: bands beyond "
      "the atmosphere's table or "
      "model, used materials whose curves do not cover them or that have no temperature for thermal light, views, "
      "point spreads, nodes of [plan]; suns, bands and edges of [[measure]] and [[budget]]; and where no air is to be "
      "solved what planning refuses, a tolerance that no plan holds. render, check, plan, chart, tune and measure "
      "begin with the same for what they compute.";
  verb.examples = {"raycube scene check park.toml"};
  verb.common = kSet;
  verb.add_options = [o](base::OptionTable& table) { table.argument("FILE", "A simulation file", o->file); };
  verb.run = [o](Invocation& invocation) {
    const auto simulation = load(invocation, o->file);  // which materials are used, only the scene tells
    const auto notices = run::check_inputs(simulation);
    for (const auto& notice : notices) invocation.log.warning(notice);
    if (invocation.common.json)
      invocation.out << simulation.resolved_json << "\n";
    else
      invocation.out << o->file << ": sound; " << base::counted(simulation.instruments.size(), "instrument") << ", "
                     << base::counted(simulation.lidars.size(), "LIDAR") << ", "
                     << base::counted(simulation.notices.size() + notices.size(), "notice") << "\n";
    return 0;
  };
  return verb;
}

Verb verb_scene_compile() {
  auto o = std::make_shared<SceneRequest>();
  Verb verb("compile", "Compile the scene of a simulation file to a .rcs file");
  verb.description =
      "The file carries the scene's buffers, trees and content hash; it depends on the simulation file no "
      "more.";
  verb.examples = {"raycube scene compile park.toml -o park.rcs"};
  verb.common = kOutput;
  verb.output_default = "FILE with the ending .rcs";
  verb.add_options = [o](base::OptionTable& table) { table.argument("FILE", "A simulation file", o->file); };
  verb.run = [o](Invocation& invocation) {
    std::string output = invocation.common.output;
    if (output.empty())
      output = (o->file.ends_with(".toml") ? o->file.substr(0, o->file.size() - 5) : o->file) + ".rcs";
    const auto simulation = load(invocation, o->file);
    scene::save_compiled(simulation.scene, output, invocation.common.overwrite);
    invocation.log.info("wrote " + output);
    print_info(invocation, simulation.scene);
    return 0;
  };
  return verb;
}

struct FormatRequest {
  std::string of;
};

/// A verb that prints one text of a kind of files, or its JSON, and reads nothing.
Verb printing(const char* name, const char* summary, std::vector<std::string> examples,
              std::string (*text)(const scene::FileFormat&), std::string (*json)(const scene::FileFormat&)) {
  auto o = std::make_shared<FormatRequest>();
  Verb verb(name, summary);
  verb.description =
      "KIND is simulation (the default), sensor (a file that an instrument names as its sensor), experiment or sweep.";
  verb.examples = std::move(examples);
  verb.add_options = [o](base::OptionTable& table) {
    table.optional_argument("KIND", "simulation, sensor, experiment or sweep", o->of);
  };
  verb.run = [o, text, json](Invocation& invocation) {
    static const std::map<std::string, const scene::FileFormat& (*)()> kinds = {
        {"", scene::simulation_format},
        {"simulation", scene::simulation_format},
        {"sensor", scene::sensor_format},
        {"experiment", experiment::experiment_format},
        {"sweep", experiment::sweep_format}};
    const auto kind = kinds.find(o->of);
    if (kind == kinds.end())
      throw base::Error(base::Fault::input,
                        "KIND: no kind of files (found '" + o->of + "'); give simulation, sensor, experiment or sweep");
    invocation.out << (invocation.common.json ? json : text)(kind->second());
    return 0;
  };
  return verb;
}

}  // namespace

Verb verb_scene() {
  Verb verb("scene", "Look at a scene, check it, compile it, print its format");
  verb.verbs = {
      verb_scene_info(), verb_scene_check(), verb_scene_compile(),
      printing("schema", "Print the JSON schema of simulation files, or of a study's or a sensor's",
               {"raycube scene schema > raycube.schema.json", "raycube scene schema sweep"}, scene::options_json_schema,
               scene::options_json_schema),
      printing("keys", "Print every key of simulation files, or of a study's or a sensor's, as Markdown tables",
               {"raycube scene keys", "raycube scene keys sensor"}, scene::options_markdown, scene::options_json)};
  return verb;
}

}  // namespace raycube::cli
