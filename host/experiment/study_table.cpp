#include "host/experiment/study_table.h"

#include <toml++/toml.h>

#include <filesystem>

#include "host/base/input_file.h"

namespace raycube::experiment {

namespace fs = std::filesystem;

struct StudyTable::State {
  std::shared_ptr<toml::table> document;  ///< owns all tables
  const toml::table* table = nullptr;
  std::string file, folder, path;
  std::shared_ptr<base::Problems> problems;
  std::set<std::string> asked;
};

StudyTable::StudyTable(std::shared_ptr<State> state) : state_(std::move(state)) {}
StudyTable::~StudyTable() = default;
StudyTable::StudyTable(StudyTable&&) noexcept = default;

StudyTable StudyTable::read(const std::string& path) {
  if (const std::string why = base::why_no_plain_file(path); !why.empty())
    throw base::Error(base::Fault::input, path + ": cannot be read: " + why);
  auto state = std::make_shared<State>();
  try {
    state->document = std::make_shared<toml::table>(toml::parse_file(path));
  } catch (const toml::parse_error& error) {
    throw base::Error(base::Fault::input, path + ":" + std::to_string(error.source().begin.line) + ": TOML syntax: " +
                                              std::string(error.description()) + "; see https://toml.io");
  }
  state->table = state->document.get();
  state->file = path, state->folder = fs::absolute(path).parent_path().string();
  state->problems = std::make_shared<base::Problems>();
  StudyTable out(state);
  if (out.number("format", 0) != 1)
    out.problem("", "a study's file begins with format = 1", out.has("format") ? "another" : "none", "write it first");
  return out;
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

bool StudyTable::has(const std::string& key) const { return state_->table->contains(key); }
bool StudyTable::is_text(const std::string& key) const {
  const toml::node* node = state_->table->get(key);
  return node != nullptr && node->is_string();
}
const std::string& StudyTable::folder() const { return state_->folder; }

std::string StudyTable::text(const std::string& key, const std::optional<std::string>& otherwise) {
  state_->asked.insert(key);
  const toml::node* node = state_->table->get(key);
  if (!node && otherwise) return *otherwise;
  if (!node) {
    problem("", "'" + key + "' is missing" + (state_->path.empty() ? "" : " in [[" + state_->path + "]]"), "",
            "add it");
    return "";
  }
  if (const auto value = node->value<std::string>(); value && node->is_string()) return *value;
  problem(key, "'" + key + "' wants a text", "another type", "put it in quotes");
  return "";
}

double StudyTable::number(const std::string& key, const std::optional<double>& otherwise) {
  state_->asked.insert(key);
  const toml::node* node = state_->table->get(key);
  if (!node && otherwise) return *otherwise;
  if (node && node->is_number()) return *node->value<double>();
  problem(node ? key : "", "'" + key + (node ? "' wants a number" : "' is missing"), node ? "another type" : "",
          node ? "give one" : "add it");
  return 0;
}

std::vector<std::string> StudyTable::texts(const std::string& key) {
  state_->asked.insert(key);
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
  state_->asked.insert(key);
  std::vector<double> out;
  const toml::node* node = state_->table->get(key);
  if (!node) return out;
  const toml::array* list = node->as_array();
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (list->get(i)->is_number()) out.push_back(*list->get(i)->value<double>());
  if (!list || out.size() != list->size())
    problem(key, "'" + key + "' wants a list of numbers", "another type", "give one");
  return out;
}

std::vector<std::vector<std::string>> StudyTable::commands(const std::string& key) {
  const toml::node* node = state_->table->get(key);
  const toml::array* list = node ? node->as_array() : nullptr;
  if (!list || list->empty() || !list->get(0)->is_array()) {
    if (!node)
      problem("", "'" + key + "' is missing in [[" + state_->path + "]]", "", "give a list: program, arguments");
    auto one = texts(key);
    std::vector<std::vector<std::string>> out;
    if (!one.empty()) out.push_back(std::move(one));
    return out;
  }
  state_->asked.insert(key);
  std::vector<std::vector<std::string>> out;
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
  state_->asked.insert(key);
  std::vector<StudyTable> out;
  const toml::node* node = state_->table->get(key);
  if (!node) return out;
  const toml::array* list = node->as_array();
  const auto add = [&](const toml::table* table) {
    auto state = std::make_shared<State>(*state_);
    state->table = table, state->path = state_->path.empty() ? key : state_->path + "." + key;
    state->asked.clear();
    out.push_back(StudyTable(state));
  };
  if (node->is_table()) {
    add(node->as_table());
    return out;
  }
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (list->get(i)->is_table()) add(list->get(i)->as_table());
  if (!list || out.size() != list->size())
    problem(key, "'" + key + "' wants tables", "another type", "write [[" + key + "]]");
  return out;
}

void StudyTable::done() {
  for (const auto& [name, node] : *state_->table) {
    const std::string key(name.str());
    if (state_->asked.count(key) == 0)
      problem(key, "unknown key" + (state_->path.empty() ? "" : " in [[" + state_->path + "]]"), "'" + key + "'",
              "docs/studies.md lists the keys");
  }
}

void StudyTable::throw_if_any() const { state_->problems->throw_if_any(); }

}  // namespace raycube::experiment
