#include <filesystem>
#include <fstream>
#include <memory>
#include <ostream>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/data_folder.h"
#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/cli/verb.h"

namespace raycube::cli {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::Fault;

/// Where each file of a new scene comes from in the program's data. Spectra are the park's restated measurements.
struct Source {
  const char* name;  ///< empty: NAME.toml
  const char* from;
};
constexpr Source kSources[] = {{"grass.csv", "scenes/park/spectra/lawn_grass.csv"},
                               {"concrete.csv", "scenes/park/spectra/concrete.csv"},
                               {"leaf.csv", "scenes/park/spectra/maple_leaf.csv"},
                               {"bark.csv", "scenes/park/spectra/bark.csv"},
                               {"tree.obj", "scenes/starter/tree.obj"},
                               {"trees.csv", "scenes/starter/trees.csv"},
                               {"", "scenes/starter/starter.toml"}};

std::string content_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  if (!(out << in.rdbuf()))
    throw Error(Fault::environment,
                path.string() + ": cannot be read; the installation is not whole (see RAYCUBE_DATA)");
  return out.str();
}

int run(Invocation& invocation, std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  const std::string name = fs::path(path).filename().string();
  if (name.empty() ||
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") != std::string::npos)
    throw Error(Fault::input, fmt::format("a scene's name has only letters, digits, _ and - (found \"{}\")", name));
  std::error_code ignored;
  if (fs::exists(path, ignored) && !(fs::is_directory(path, ignored) && fs::is_empty(path, ignored)))
    throw Error(Fault::input, path + ": is there already; `raycube new` never overwrites, choose another name");
  const fs::path data = base::data_folder();
  base::OutputSet set(path);
  auto files = nlohmann::ordered_json::array();
  for (const auto& source : kSources) {
    const std::string file = *source.name ? source.name : name + ".toml";
    set.add(file).append(content_of(data / source.from));
    files.push_back((fs::path(path) / file).string());
  }
  set.publish();
  const std::string scene = files.back();
  if (invocation.common.json)
    invocation.out << nlohmann::ordered_json{{"scene", scene}, {"files", files}}.dump(2) << "\n";
  else
    invocation.out << scene << "\n";
  invocation.log.info(fmt::format("next: raycube render {} -o {}-out", scene, name));
  return 0;
}

}  // namespace

Verb verb_new() {
  const auto path = std::make_shared<std::string>();
  Verb verb("new", "Write a small commented scene to start from");
  verb.description =
      "Makes the folder NAME with NAME.toml and the few small files it names. It renders in seconds. A folder that "
      "holds anything is left alone.";
  verb.examples = {"raycube new garden && raycube render garden/garden.toml -o out"};
  verb.add_options = [path](base::OptionTable& table) {
    table.argument("NAME", "Folder to make; its last part names the scene", *path);
  };
  verb.run = [path](Invocation& invocation) { return run(invocation, *path); };
  return verb;
}

}  // namespace raycube::cli
