// The layers of docs/design.md, held: its table read, every #include of our own files walked.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = RAYCUBE_SOURCE_DIR;

/// One row of the table: folders or single files, relative to the repository.
struct Layer {
  std::vector<std::string> paths, may_include;
};

std::string text_of(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

std::vector<std::string> all_matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> out;
  for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i) out.push_back((*i)[1]);
  return out;
}

/// Rows `| `layer` | what | `may`, `include` |` under the heading "House map".
std::vector<Layer> house_map(const std::string& document) {
  static const std::regex code("`([^`]+)`");
  std::vector<Layer> layers;
  std::istringstream lines(document.substr(document.find("## House map")));
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| `", 0) != 0) continue;
    const auto first = line.find('|', 1), last = line.rfind('|', line.size() - 2);
    REQUIRE(first < last);
    layers.push_back({all_matches(line.substr(0, first), code), all_matches(line.substr(last), code)});
  }
  return layers;
}

/// `path` is `place` or lies in it.
bool inside(const std::string& path, const std::string& place) {
  return path == place || path.rfind(place + "/", 0) == 0;
}

bool any_holds(const std::vector<std::string>& places, const std::string& path) {
  return std::any_of(places.begin(), places.end(), [&](const std::string& place) { return inside(path, place); });
}

/// The layer of a file: the row that names it, else the row of its folder. -1: none.
int layer_of(const std::vector<Layer>& layers, const std::string& file) {
  int found = -1;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < layers.size(); ++i)
    for (const auto& place : layers[i].paths)
      if (inside(file, place) && place.size() >= longest) found = static_cast<int>(i), longest = place.size();
  return found;
}

/// A file that is a row of its own belongs to its folder's row too.
bool allowed(const std::vector<Layer>& layers, int layer, const std::string& include) {
  if (any_holds(layers[layer].paths, include) || any_holds(layers[layer].may_include, include)) return true;
  return layer_of(layers, include) == layer;
}

/// Our own files that `file` includes, as paths from the root; a name that is no file of ours (generated) is left out.
std::vector<std::string> own_includes(const std::string& file, const std::string& text) {
  static const std::regex pattern("(?:^|\n)[ \t]*#[ \t]*include[ \t]*\"([^\"]+)\"");
  std::vector<std::string> out;
  for (const auto& name : all_matches(text, pattern)) {
    const std::string beside = (fs::path(file).parent_path() / name).lexically_normal();
    if (fs::exists(kRoot / name))
      out.push_back(name);
    else if (fs::exists(kRoot / beside))
      out.push_back(beside);
  }
  return out;
}

}  // namespace

TEST_CASE("house map: every file belongs to a layer and includes what its layer may") {
  const auto layers = house_map(text_of(kRoot / "docs/design.md"));
  REQUIRE(layers.size() >= 15);
  int files = 0, includes = 0;
  for (const char* top : {"kernels", "host", "atmos_tables", "scene_compiler"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp" && extension != ".cl" && extension != ".def" && extension != ".inc")
        continue;
      const std::string file = entry.path().lexically_relative(kRoot);
      ++files;
      const int layer = layer_of(layers, file);
      CHECK_MESSAGE(layer >= 0, file << " lies in no layer of docs/design.md");
      if (layer < 0) continue;
      for (const auto& include : own_includes(file, text_of(entry.path()))) {
        ++includes;
        CHECK_MESSAGE(allowed(layers, layer, include), file << " may not include " << include);
      }
    }
  MESSAGE(files << " files, " << includes << " includes, " << layers.size() << " layers");
  CHECK(files > 100);
  CHECK(includes > 300);
}

TEST_CASE("house map: what a layer may include lies in rows above it, and exists") {
  const auto layers = house_map(text_of(kRoot / "docs/design.md"));
  for (std::size_t i = 0; i < layers.size(); ++i) {
    for (const auto& place : layers[i].paths) CHECK_MESSAGE(fs::exists(kRoot / place), place);
    for (const auto& place : layers[i].may_include) {
      if (place == "host") continue;  // the verbs' row, the last one
      const int above = layer_of(layers, place);
      CHECK_MESSAGE(above >= 0, place);
      CHECK_MESSAGE(above < static_cast<int>(i), layers[i].paths[0] << " names " << place << ", which lies below it");
    }
  }
}

TEST_CASE("house map: the walk sees a forbidden include") {
  const auto layers = house_map(
      "## House map\n| layer | x | may |\n| `low` | | nothing |\n| `low/data.h` | | `low` |\n"
      "| `high` | text with `code` | `low/data.h` |\n");
  REQUIRE(layers.size() == 3);
  const int low = layer_of(layers, "low/a.cpp"), high = layer_of(layers, "high/b/c.h");
  CHECK(low == 0);
  CHECK(high == 2);
  CHECK(layer_of(layers, "low/data.h") == 1);
  CHECK(layer_of(layers, "lower/a.h") == -1);
  CHECK(allowed(layers, high, "low/data.h"));
  CHECK(!allowed(layers, high, "low/other.h"));
  CHECK(!allowed(layers, low, "high/b/c.h"));
  const auto found = own_includes(
      "host/cli/main.cpp",
      "#include <vector>\n  #  include \"host/base/error.h\"\n#include \"verb.h\"\n// #include \"verb.h\"\n");
  CHECK(found == std::vector<std::string>{"host/base/error.h", "host/cli/verb.h"});
}
