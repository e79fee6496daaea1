#include "scene_compiler/document.h"

#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>

#include "host/base/input_file.h"
#include "host/base/text.h"
#include "scene_compiler/document_overrides.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

namespace fs = std::filesystem;
using base::Problems;
using base::Where;

struct File {
  std::string name;  ///< as reported
  fs::path folder;
};

constexpr int kKeyParts = 32;

struct Place {
  int line = 1, column = 1;
};

/// Where the first key begins to have more than kKeyParts parts. toml++ makes a table of each and goes
/// through them by recursion, so that tens of thousands end the program. Dots in strings and comments do not
/// count; numbers and times have one.
std::optional<Place> too_deep_key(const std::string& text) {
  Place at;
  int dots = 0;
  std::size_t i = 0;
  const auto next = [&] {
    if (text[i] == '\n') ++at.line, at.column = 0;
    ++at.column, ++i;
  };
  const auto skip_string = [&] {
    const char quote = text[i];
    const bool many_lines = text.compare(i, 3, std::string(3, quote)) == 0;
    const std::string end(many_lines ? 3 : 1, quote);
    for (std::size_t k = 0; k < end.size(); ++k) next();
    while (i < text.size() && text.compare(i, end.size(), end) != 0 && (many_lines || text[i] != '\n')) {
      if (quote == '"' && text[i] == '\\' && i + 1 < text.size()) next();
      next();
    }
    for (std::size_t k = 0; k < end.size() && i < text.size() && text[i] == quote; ++k) next();
  };
  while (i < text.size()) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      skip_string();
      continue;
    }
    if (c == '#')
      while (i + 1 < text.size() && text[i + 1] != '\n') next();
    if (std::string_view("\n=,[]{}#").find(c) != std::string_view::npos) dots = 0;
    if (c == '.' && ++dots >= kKeyParts) return at;
    next();
  }
  return std::nullopt;
}

Where where_of(const File& file, const toml::source_region& region) {
  return {file.name, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column), ""};
}

std::string type_found(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "text \"" + **node.as_string() + "\"";
    case toml::node_type::integer:
      return "integer " + std::to_string(**node.as_integer());
    case toml::node_type::floating_point:
      return "number " + number_text(**node.as_floating_point());
    case toml::node_type::boolean:
      return **node.as_boolean() ? "true" : "false";
    default:
      return "a date or time";
  }
}

class DocumentReader {
 public:
  DocumentReader(Problems& problems, Overrides& overrides) : problems_(problems), overrides_(overrides) {}

  void read_file(const fs::path& path, const std::string& name, const Where& asked_by, Record& root) {
    std::error_code ignored;
    const fs::path canonical = fs::weakly_canonical(path, ignored);
    for (std::size_t i = 0; i < open_.size(); ++i) {
      if (open_[i] != canonical) continue;
      std::string chain;
      for (std::size_t j = i; j < open_.size(); ++j) chain += open_[j].filename().string() + " -> ";
      problems_.add(asked_by, "include runs in a circle", chain + canonical.filename().string(),
                    "remove one of these includes");
      return;
    }
    for (const auto& done : done_)
      if (done == canonical) {
        problems_.add(asked_by, "file is included twice", name, "include it once");
        return;
      }
    const File file{name, path.parent_path()};
    auto table = parsed(path, file, asked_by, "simulation file");
    if (!table) return;
    overrides_.apply(*table);
    open_.push_back(canonical);
    check_format(*table, file);
    read_table(*table, file, "", root);
    includes(*table, file, root);
    open_.pop_back();
    done_.push_back(canonical);
  }

 private:
  /// The file's TOML; nothing after reporting what is wrong with it.
  std::optional<toml::table> parsed(const fs::path& path, const File& file, const Where& asked_by,
                                    const std::string& kind) {
    const std::string& name = file.name;
    std::error_code ignored;
    if (const std::string why = base::why_no_plain_file(path.string()); !why.empty()) {
      problems_.add(asked_by.file.empty() ? Where{name, 0, 0, ""} : asked_by, "cannot read " + kind,
                    fs::exists(path, ignored) ? name + ", which " + why : name,
                    "check the path; it is relative to the file that names it");
      return std::nullopt;
    }
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    if (text.str().find_first_not_of(" \t\r\n") == std::string::npos) {
      problems_.add({name, 1, 1, ""}, "file is empty", base::counted(text.str().size(), "byte"),
                    "a " + kind + " begins with format = 1");
      return std::nullopt;
    }
    if (const auto deep = too_deep_key(text.str())) {
      problems_.add({name, deep->line, deep->column, ""}, "key has too many parts",
                    "more than " + std::to_string(kKeyParts) + " between dots",
                    "no key of a " + kind + " has more than four");
      return std::nullopt;
    }
    try {
      return toml::parse(text.str(), name);
    } catch (const toml::parse_error& error) {
      problems_.add(where_of(file, error.source()), "TOML syntax: " + std::string(error.description()), "",
                    "see https://toml.io");
      return std::nullopt;
    }
  }

  /// What a sensor's file says of an instrument where the instrument's own table says nothing.
  void read_sensor(Record& record) {
    const Value& asked = record.values["sensor"];
    const fs::path path(asked.text);
    const File file{asked.text, path.parent_path()};
    auto table = parsed(path, file, asked.where, "sensor's file");
    if (!table) return;
    check_format(*table, file);
    std::vector<std::string> said;  // by the instrument itself, which counts
    for (const auto& [key, node] : *table) {
      const std::string name(key.str());
      if (is_instruments_own(name))
        problems_.add(where_of(file, key.source()), "a sensor's file has no '" + name + "'", "", "remove it");
      if (name == "format" || is_instruments_own(name) || gives(record, name) || stands_in(record, name))
        said.push_back(name);
    }
    for (const std::string& name : said) table->erase(name);
    overrides_.apply(*table, "instrument." + record.values["name"].text);
    read_table(*table, file, record.path, record);
  }

  static bool gives(const Record& record, std::string_view key) {
    const auto found = record.values.find(key);
    return found != record.values.end() && found->second.given;
  }

  /// Whether the instrument says in another way what this key of a sensor's file says.
  static bool stands_in(const Record& record, std::string_view name) {
    static const std::map<std::string_view, std::vector<std::string_view>> instead = {
        {"gsd_m", {"ifov_mrad", "focal_length_mm"}},
        {"ifov_mrad", {"gsd_m", "focal_length_mm"}},
        {"focal_length_mm", {"gsd_m", "ifov_mrad"}},
        {"altitude_agl_m", {"position_m", "poses"}},
        {"position_m", {"altitude_agl_m", "poses"}},
        {"poses", {"altitude_agl_m", "position_m"}},
        {"center_m", {"position_m", "poses"}},
        {"line_spacing_m", {"poses"}},
        {"psf", {"focal_plane"}},
        {"focal_plane", {"psf"}},
        {"oversampling", {"psf"}},
        {"quicklook_nm", {"quicklook_bands"}},
        {"quicklook_bands", {"quicklook_nm"}}};
    const auto others = instead.find(name);
    return others != instead.end() && std::any_of(others->second.begin(), others->second.end(),
                                                  [&](std::string_view other) { return gives(record, other); });
  }

  void check_format(const toml::table& table, const File& file) {
    const toml::node* format = table.get("format");
    if (format == nullptr) {
      problems_.add({file.name, 1, 1, ""}, "format is missing", "", "begin the file with format = 1");
      return;
    }
    for (const auto& [key, node] : table)
      if (node.source().begin.line > 0 && node.source().begin.line < format->source().begin.line) {  // 0: --set
        problems_.add(where_of(file, format->source()), "format is not the first key",
                      "'" + std::string(key.str()) + "' before it", "move format = 1 to the top");
        return;
      }
  }

  void includes(const toml::table& table, const File& file, Record& root) {
    const auto* list = table["scene"]["include"].as_array();
    if (list == nullptr) return;
    for (const auto& node : *list) {
      const auto name = node.value<std::string>();
      if (!name) continue;  // its type was reported with the key
      const fs::path path = fs::path(*name).is_absolute() ? fs::path(*name) : file.folder / *name;
      read_file(path, (fs::path(file.name).parent_path() / *name).string(), where_of(file, node.source()), root);
    }
  }

  void read_table(const toml::table& table, const File& file, const std::string& path, Record& record) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      const Where where = where_of(file, key.source());
      const KeySpec* spec = find_key(path, name);
      if (spec == nullptr) {
        unknown_key(path, name, where);
        continue;
      }
      Value& value = record.values[name];
      if (spec->type == KeyType::tables) {
        read_tables(*spec, node, file, where, value);
      } else if (spec->type == KeyType::table || (spec->type == KeyType::path_or_table && node.is_table())) {
        read_sub_table(*spec, node, file, where, value);
      } else if (value.given && !(path.empty() && name == "format") && !(path == "scene" && name == "include")) {
        problems_.add(where, "'" + name + "' is given twice", "first in " + value.where.text(), "keep one of them");
      } else {
        value = Value{};
        value.given = true;
        value.where = where;
        read_value(*spec, node, file, value);
      }
    }
  }

  void unknown_key(const std::string& path, const std::string& name, const Where& where) {
    const std::string nearest = nearest_key(simulation_format(), path, name);
    std::string way_out = nearest.empty() ? "" : "did you mean '" + nearest + "'?";
    if (nearest.empty()) {
      for (const auto& spec : option_keys())
        if (spec.key == name)
          way_out += (way_out.empty() ? "it belongs in [" : ", [") +
                     (spec.table.empty() ? "top level" : std::string(spec.table)) + "]";
      if (way_out.empty()) way_out = "docs/scene_format.md lists the keys";
    }
    problems_.add(where, "unknown key" + (path.empty() ? std::string(" at top level") : " in [" + path + "]"),
                  "'" + name + "'", way_out);
  }

  void read_tables(const KeySpec& spec, const toml::node& node, const File& file, const Where& where, Value& value) {
    const std::string path = sub_path(spec);
    const auto add = [&](const toml::table& table) {
      Record record;
      record.path = path;
      record.where = where_of(file, table.source());
      const std::size_t before = problems_.count();
      read_table(table, file, path, record);
      if (gives(record, "sensor")) read_sensor(record);
      record.sound = problems_.count() == before;
      value.records.push_back(std::move(record));
    };
    const auto* array = node.as_array();
    // Inside another table one entry may stand alone: line = { ... }.
    const bool one = node.is_table() && !spec.table.empty();
    if (array == nullptr && !one) {
      problems_.add(where, "'" + std::string(spec.key) + "' wants an array of tables", type_found(node),
                    "write [[" + path + "]]");
      return;
    }
    value.given = true;
    value.where = where;
    if (one) return add(*node.as_table());
    for (const auto& item : *array) {
      if (item.is_table())
        add(*item.as_table());
      else
        problems_.add(where_of(file, item.source()), "'" + path + "' holds tables only", type_found(item),
                      "write [[" + path + "]]");
    }
  }

  void read_sub_table(const KeySpec& spec, const toml::node& node, const File& file, const Where& where, Value& value) {
    if (!node.is_table()) {
      problems_.add(where, "'" + std::string(spec.key) + "' wants a table", type_found(node),
                    "write [" + sub_path(spec) + "] or " + std::string(spec.key) + " = { ... }");
      return;
    }
    if (value.records.empty()) {
      value.given = true;
      value.where = where;
      Record record;
      record.path = sub_path(spec);
      record.where = where_of(file, node.source());
      value.records.push_back(std::move(record));
    }
    const std::size_t before = problems_.count();
    read_table(*node.as_table(), file, sub_path(spec), value.records.front());
    if (problems_.count() != before) value.records.front().sound = false;
  }

  void wrong_type(const KeySpec& spec, const toml::node& node, const File& file, const std::string& wanted) {
    problems_.add(where_of(file, node.source()), "'" + std::string(spec.key) + "' wants " + wanted, type_found(node),
                  std::string(spec.text));
  }

  bool read_number(const KeySpec& spec, const toml::node& node, const File& file, double& out) {
    if (!node.is_number()) {
      wrong_type(spec, node, file, "a number");
      return false;
    }
    out = *node.value<double>();
    return in_range(spec, out, where_of(file, node.source()), problems_);
  }

  bool read_integer(const KeySpec& spec, const toml::node& node, const File& file, std::int64_t& out) {
    if (!node.is_integer()) {
      wrong_type(spec, node, file, "an integer");
      return false;
    }
    out = **node.as_integer();
    return in_range(spec, static_cast<double>(out), where_of(file, node.source()), problems_);
  }

  const toml::array* list(const KeySpec& spec, const toml::node& node, const File& file, const std::string& wanted) {
    const auto* array = node.as_array();
    if (array == nullptr) {
      wrong_type(spec, node, file, wanted);
    } else if (!shape_allows(spec, array->size())) {
      problems_.add(where_of(file, node.source()), "'" + std::string(spec.key) + "' has the wrong length",
                    base::counted(array->size(), "value"), "give " + std::string(spec.shape) + " values");
      return nullptr;
    }
    return array;
  }

  void read_point(const KeySpec& spec, const toml::node& node, const File& file, Value& value) {
    const auto* pair = node.as_array();
    double x = 0, y = 0;
    if (pair == nullptr || pair->size() != 2) {
      wrong_type(spec, node, file, "pairs [x, y]");
    } else if (read_number(spec, *pair->get(0), file, x) && read_number(spec, *pair->get(1), file, y)) {
      value.points.emplace_back(x, y);
    }
  }

  void read_text_map(const KeySpec& spec, const toml::node& node, const File& file, Value& value) {
    const auto* table = node.as_table();
    if (table == nullptr) {
      wrong_type(spec, node, file, "a table of texts");
      return;
    }
    for (const auto& [key, item] : *table) {
      Value entry;
      entry.given = true;
      entry.where = where_of(file, item.source());
      if (!item.is_string()) {
        wrong_type(spec, item, file, "a table of texts");
        continue;
      }
      entry.text = **item.as_string();
      value.map.push_back({std::string(key.str()), std::move(entry)});
    }
  }

  void read_value(const KeySpec& spec, const toml::node& node, const File& file, Value& value) {
    switch (spec.type) {
      case KeyType::boolean:
        if (node.is_boolean())
          value.boolean = **node.as_boolean();
        else
          wrong_type(spec, node, file, "true or false");
        break;
      case KeyType::integer:
        read_integer(spec, node, file, value.integer);
        break;
      case KeyType::integer_or_word:
        if (node.is_string() && **node.as_string() == spec.shape)
          value.text = spec.shape;
        else if (node.is_integer())
          read_integer(spec, node, file, value.integer);
        else
          wrong_type(spec, node, file, "an integer or \"" + std::string(spec.shape) + "\"");
        break;
      case KeyType::number:
        read_number(spec, node, file, value.number);
        break;
      case KeyType::choice:
        if (!node.is_string() || !is_choice(spec, **node.as_string())) {
          wrong_type(spec, node, file, "one of " + choices_text(spec));
          fill_default(spec, value);
        } else {
          value.text = **node.as_string();
        }
        break;
      case KeyType::choices:
        if (!node.is_array()) wrong_type(spec, node, file, "a list of " + choices_text(spec));
        for (const auto& item : node.is_array() ? *node.as_array() : toml::array())
          if (!item.is_string() || !is_choice(spec, **item.as_string()))
            wrong_type(spec, item, file, "a list of " + choices_text(spec));
          else
            value.texts.push_back(**item.as_string());
        break;
      case KeyType::text:
      case KeyType::path:
      case KeyType::path_or_table:
        if (!node.is_string() || (**node.as_string()).empty()) {
          wrong_type(spec, node, file, "text");
        } else {
          value.text = **node.as_string();
          if (spec.type != KeyType::text && !fs::path(value.text).is_absolute())
            value.text = (file.folder / value.text).lexically_normal().string();
        }
        break;
      case KeyType::integers:
        if (const auto* array = list(spec, node, file, "a list of integers"))
          for (const auto& item : *array) read_integer(spec, item, file, value.integers.emplace_back(0));
        break;
      case KeyType::numbers:
        if (const auto* array = list(spec, node, file, "a list of numbers"))
          for (const auto& item : *array) read_number(spec, item, file, value.numbers.emplace_back(0));
        break;
      case KeyType::number_or_numbers:
        if (node.is_number()) {
          read_number(spec, node, file, value.number);
          value.numbers = {value.number};
        } else if (const auto* array = list(spec, node, file, "a number or a list of numbers")) {
          for (const auto& item : *array) read_number(spec, item, file, value.numbers.emplace_back(0));
          if (value.numbers.size() == 1) value.number = value.numbers.front();
        }
        break;
      case KeyType::points:
        if (const auto* array = list(spec, node, file, "a list of [x, y]"))
          for (const auto& item : *array) read_point(spec, item, file, value);
        break;
      case KeyType::texts:
        if (const auto* array = list(spec, node, file, "a list of texts"))
          for (const auto& item : *array) {
            if (!item.is_string()) {
              wrong_type(spec, item, file, "a list of texts");
              continue;
            }
            value.texts.push_back(**item.as_string());
            value.text_places.push_back(where_of(file, item.source()));
          }
        break;
      case KeyType::text_map:
        read_text_map(spec, node, file, value);
        break;
      case KeyType::table:
      case KeyType::tables:
      case KeyType::commands:  // of studies alone
        break;                 // read_table sends tables elsewhere
    }
  }

  Problems& problems_;
  Overrides& overrides_;
  std::vector<fs::path> open_, done_;
};

}  // namespace

Record read_document(const std::string& file, base::Problems& problems, const std::vector<std::string>& overrides) {
  Record root;
  root.where = {file, 1, 1, ""};
  const std::size_t before = problems.count();
  Overrides values(overrides, problems);
  DocumentReader(problems, values).read_file(file, file, {}, root);
  if (problems.count() == before) values.report_unused(file, problems);
  const bool parsed = problems.count() == before || !root.values.empty();
  fill_defaults(root, parsed ? &problems : nullptr);
  return root;
}

}  // namespace raycube::scene
