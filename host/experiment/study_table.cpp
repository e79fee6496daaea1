#include "host/experiment/study_table.h"

#include <toml++/toml.h>

#include <cmath>
#include <filesystem>

#include "host/base/input_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::experiment {

namespace fs = std::filesystem;
using scene::KeySpec;

struct StudyTable::State {
  std::shared_ptr<toml::table> document;  ///< owns all tables
  const toml::table* table = nullptr;
  const scene::FileFormat* format = nullptr;
  std::string file, folder, path;
  std::shared_ptr<base::Problems> problems;
};

StudyTable::StudyTable(std::shared_ptr<State> state) : state_(std::move(state)) { report_unknown_keys(); }
StudyTable::~StudyTable() = default;
StudyTable::StudyTable(StudyTable&&) noexcept = default;

StudyTable StudyTable::read(const std::string& path, const scene::FileFormat& format) {
  if (const std::string why = base::why_no_plain_file(path); !why.empty())
    throw base::Error(base::Fault::input, path + ": cannot be read: " + why);
  auto state = std::make_shared<State>();
  try {
    state->document = std::make_shared<toml::table>(toml::parse_file(path));
  } catch (const toml::parse_error& error) {
    throw base::Error(base::Fault::input, path + ":" + std::to_string(error.source().begin.line) + ": TOML syntax: " +
                                              std::string(error.description()) + "; see https://toml.io");
  }
  state->table = state->document.get(), state->format = &format;
  state->file = path, state->folder = fs::absolute(path).parent_path().string();
  state->problems = std::make_shared<base::Problems>();
  StudyTable out(state);
  out.number("format");
  return out;
}

const KeySpec& StudyTable::spec(const std::string& key) const {
  const KeySpec* found = scene::find_key(*state_->format, state_->path, key);
  if (!found) throw base::Error(base::Fault::bug, "option table has no key '" + key + "' in [" + state_->path + "]");
  return *found;
}

std::string StudyTable::in() const {
  if (state_->path.empty()) return "";
  const std::string key = state_->path.substr(state_->path.rfind('.') + 1);
  const std::string above = key.size() == state_->path.size() ? "" : state_->path.substr(0, state_->path.rfind('.'));
  const KeySpec* opened_by = scene::find_key(*state_->format, above, key);
  const bool list = opened_by != nullptr && opened_by->type == scene::KeyType::tables;
  return list ? " in [[" + state_->path + "]]" : " in [" + state_->path + "]";
}

base::Where StudyTable::where(const std::string& key) const {
  const toml::node* node = key.empty() ? nullptr : state_->table->get(key);
  const auto& source = node ? node->source() : state_->table->source();
  return {state_->file, static_cast<int>(source.begin.line), static_cast<int>(source.begin.column), ""};
}

void StudyTable::problem(const std::string& key, const std::string& what, const std::string& found,
                         const std::string& way_out) {
  state_->problems->add(where(key), what, found, way_out);
}

void StudyTable::missing(const std::string& key, const std::string& way_out) {
  problem("", "'" + key + "' is missing" + in(), "", way_out);
}

bool StudyTable::has(const std::string& key) const { return state_->table->contains(key); }
const std::string& StudyTable::folder() const { return state_->folder; }

std::string StudyTable::text(const std::string& key) {
  const KeySpec& row = spec(key);
  const toml::node* node = state_->table->get(key);
  const std::string otherwise(row.has_default() ? row.fallback : "");
  if (!node) {
    if (row.required()) missing(key, "add it");
    return otherwise;
  }
  if (!node->is_string()) {
    problem(key, "'" + key + "' wants a text", "another type", "put it in quotes");
    return otherwise;
  }
  const std::string said = **node->as_string();
  if (row.type == scene::KeyType::choice && !scene::is_choice(row, said)) {
    problem(key, "'" + key + "' is none of its choices", "'" + said + "'", "choose of " + scene::choices_text(row));
    return otherwise;
  }
  return said;
}

double StudyTable::number(const std::string& key) {
  const KeySpec& row = spec(key);
  const toml::node* node = state_->table->get(key);
  const double otherwise = row.has_default() ? std::stod(std::string(row.fallback)) : 0;
  if (!node) {
    if (row.required()) missing(key, "add it");
    return otherwise;
  }
  if (!node->is_number()) {
    problem(key, "'" + key + "' wants a number", "another type", "give one");
    return otherwise;
  }
  const double said = *node->value<double>();
  if (row.type == scene::KeyType::integer && std::isfinite(said) && said != std::floor(said)) {
    problem(key, "'" + key + "' wants a whole number", scene::number_text(said), "give one");
    return otherwise;
  }
  return scene::in_range(row, said, where(key), *state_->problems) ? said : otherwise;
}

std::vector<std::string> StudyTable::texts(const std::string& key) {
  std::vector<std::string> out;
  const toml::node* node = state_->table->get(key);
  if (!node) return out;
  const toml::array* list = node->as_array();
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (list->get(i)->is_string()) out.push_back(**list->get(i)->as_string());
  if (!list || out.size() != list->size())
    problem(key, "'" + key + "' wants a list of texts", "another type", "give one");
  return out;
}

std::vector<double> StudyTable::numbers(const std::string& key) {
  std::vector<double> out;
  const toml::node* node = state_->table->get(key);
  if (!node) return out;
  const toml::array* list = node->as_array();
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (list->get(i)->is_number()) out.push_back(*list->get(i)->value<double>());
  if (!list || out.size() != list->size())
    problem(key, "'" + key + "' wants a list of numbers", "another type", "give one");
  for (const double value : out) scene::in_range(spec(key), value, where(key), *state_->problems);
  return out;
}

std::vector<std::vector<std::string>> StudyTable::commands(const std::string& key) {
  const toml::node* node = state_->table->get(key);
  const toml::array* list = node ? node->as_array() : nullptr;
  std::vector<std::vector<std::string>> out;
  if (!node) {
    missing(key, "give a list: program, arguments");
    return out;
  }
  if (!list || list->empty() || !list->get(0)->is_array()) {
    auto one = texts(key);
    if (list && list->empty()) problem(key, "'" + key + "' has no command", "an empty list", "give program, arguments");
    if (!one.empty()) out.push_back(std::move(one));
    return out;
  }
  for (const toml::node& item : *list) {
    auto& command = out.emplace_back();
    const toml::array* words = item.as_array();
    for (std::size_t i = 0; words && i < words->size(); ++i)
      if (words->get(i)->is_string()) command.push_back(**words->get(i)->as_string());
    if (!words || command.size() != words->size() || command.empty())
      problem(key, "a command is a list of texts", "another type", "give program and arguments");
  }
  return out;
}

std::vector<StudyTable> StudyTable::tables(const std::string& key) {
  const KeySpec& row = spec(key);
  std::vector<StudyTable> out;
  const toml::node* node = state_->table->get(key);
  if (!node) return out;
  const toml::array* list = row.type == scene::KeyType::tables ? node->as_array() : nullptr;
  const auto add = [&](const toml::table* table) {
    auto state = std::make_shared<State>(*state_);
    state->table = table, state->path = scene::sub_path(row);
    out.push_back(StudyTable(state));
  };
  if (node->is_table()) {
    add(node->as_table());
    return out;
  }
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (list->get(i)->is_table()) add(list->get(i)->as_table());
  if (!list || out.size() != list->size())
    problem(key, "'" + key + "' wants " + (row.type == scene::KeyType::tables ? "tables" : "one table"), "another type",
            row.type == scene::KeyType::tables ? "write [[" + key + "]]" : "write [" + key + "]");
  return out;
}

void StudyTable::report_unknown_keys() {
  for (const auto& [name, node] : *state_->table) {
    const std::string key(name.str());
    if (scene::find_key(*state_->format, state_->path, key)) continue;
    const std::string nearest = scene::nearest_key(*state_->format, state_->path, key);
    problem(key, "unknown key" + in(), "'" + key + "'",
            nearest.empty() ? "docs/studies.md lists the keys" : "did you mean '" + nearest + "'?");
  }
}

void StudyTable::throw_if_any() const { state_->problems->throw_if_any(); }

}  // namespace raycube::experiment
