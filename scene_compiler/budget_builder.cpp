#include "scene_compiler/budget_builder.h"

#include <algorithm>
#include <map>
#include <set>
#include <type_traits>

#include "scene_compiler/document_values.h"
#include "scene_compiler/measure_builder.h"

namespace raycube::scene {
namespace {

using base::Problems;

/// Materials of all planes and terrains.
std::set<std::string> flat_materials(const Record& root) {
  std::set<std::string> out;
  const auto take = [&](const Record& record, const char* key) {
    if (record.given(key)) out.insert(record.text(key));
  };
  for (const Record& plane : root.records("plane")) {
    take(plane, "material");
    if (const Record* checker = plane.table("checker"))
      for (const std::string& name : checker->value("materials").texts) out.insert(name);
  }
  for (const Record& terrain : root.records("terrain")) {
    take(terrain, "material");
    for (const NamedValue& entry : terrain.value("materials").map) out.insert(entry.value.text);
  }
  return out;
}

/// Reports names that the file does not have among entries of a kind.
void check_known(const Record& record, const char* key, const std::vector<Record>& entries, const std::string& kind,
                 Problems& problems) {
  std::string known;
  for (const Record& entry : entries) known += (known.empty() ? "" : ", ") + entry.text("name");
  for (const std::string& name : record.value(key).texts)
    if (std::none_of(entries.begin(), entries.end(), [&](const Record& entry) { return entry.text("name") == name; }))
      problems.add(record.place(key), "no " + kind + " of that name", "'" + name + "'",
                   known.empty() ? "the file has none" : "the file has: " + known);
}

/// Reports what a list names twice.
template <class T>
void check_once(const Record& record, const char* key, std::vector<T> list, Problems& problems) {
  std::sort(list.begin(), list.end());
  if (const auto twice = std::adjacent_find(list.begin(), list.end()); twice != list.end()) {
    if constexpr (std::is_same_v<T, double>)
      problems.add(record.place(key), "'" + std::string(key) + "' has one twice", number_text(*twice), "give it once");
    else
      problems.add(record.place(key), "'" + std::string(key) + "' has one twice", "'" + *twice + "'", "give it once");
  }
}

LightBudget read_budget(const Record& record, const Record& root, Problems& problems) {
  LightBudget out;
  out.name = record.text("name");
  out.bands_of = banded_instrument(record, root.records("instrument"), problems);
  out.isotropic = record.text("light") == "isotropic";
  std::copy_n(record.numbers("center_m").begin(), 2, out.center_m.begin());
  const Record* scene = root.table("scene");
  const bool repeats = scene != nullptr && scene->table("periodic") != nullptr;
  if (record.given("size_m")) {
    out.size_m.emplace();
    std::copy_n(record.numbers("size_m").begin(), 2, out.size_m->begin());
    if (repeats)
      problems.add(record.place("size_m"), "in a scene that repeats the area is the cell",
                   number_text(out.size_m->at(0)) + ", " + number_text(out.size_m->at(1)), "remove size_m");
  } else if (!repeats) {
    problems.add(record.where, "a budget needs an area", "no size_m, and no scene.periodic",
                 "give size_m = [width, length]");
  }
  if (repeats && record.given("center_m"))
    problems.add(record.place("center_m"), "in a scene that repeats the area is the cell", "", "remove center_m");
  if (record.given("height_m")) out.height_m = record.number("height_m");
  check_known(record, "ground", root.records("material"), "material", problems);
  check_known(record, "facets", root.records("mesh"), "mesh", problems);
  check_once(record, "levels_m", record.numbers("levels_m"), problems);
  check_once(record, "facets", record.value("facets").texts, problems);
  for (const std::string& name : record.value("facets").texts) check_file_name(record, "facets", name, problems);
  const auto& ground = record.value("ground").texts;
  if (record.given("ground"))
    out.ground = ground;
  else
    for (const std::string& name : flat_materials(root)) out.ground.push_back(name);
  out.par = record.boolean("par");
  out.levels_m = record.numbers("levels_m");
  out.facets = record.value("facets").texts;
  out.photons = static_cast<std::uint64_t>(record.integer("photons"));
  return out;
}

}  // namespace

std::vector<LightBudget> read_budgets(const Record& root, Problems& problems) {
  std::vector<LightBudget> out;
  std::map<std::string, std::string> places;
  for (const Record& measure : root.records("measure"))
    places.emplace(measure.text("name"), "[[measure]] in " + measure.where.text());
  for (const Record& record : root.records("budget")) {
    const std::string& name = record.text("name");
    check_folder_name(record, "a budget", problems);
    if (const auto [place, fresh] = places.emplace(name, record.where.text()); !fresh)
      problems.add(record.where, "'" + name + "' names another measure or budget", "first in " + place->second,
                   "rename one");
    if (record.sound) out.push_back(read_budget(record, root, problems));
  }
  return out;
}

}  // namespace raycube::scene
