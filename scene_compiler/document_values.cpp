#include "scene_compiler/document_values.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace raycube::scene {
namespace {

std::vector<double> parse_list(std::string_view text) {
  std::vector<double> out;
  while (!text.empty()) {
    while (!text.empty() && (text[0] == ' ' || text[0] == ',')) text.remove_prefix(1);
    double number = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), number).ptr;
    if (end == text.data()) break;
    out.push_back(number);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return out;
}

nlohmann::ordered_json value_json(const KeySpec& spec, const Value& value);

nlohmann::ordered_json record_json(const Record& record) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  for (const auto& spec : option_keys()) {
    if (spec.table != record.path) continue;
    const auto found = record.values.find(spec.key);
    if (found == record.values.end() || (!found->second.given && !spec.has_default())) continue;
    out[std::string(spec.key)] = value_json(spec, found->second);
  }
  return out;
}

nlohmann::ordered_json value_json(const KeySpec& spec, const Value& value) {
  using Json = nlohmann::ordered_json;
  switch (spec.type) {
    case KeyType::boolean:
      return value.boolean;
    case KeyType::integer:
      return value.integer;
    case KeyType::integer_or_word:
      return value.text.empty() ? nlohmann::ordered_json(value.integer) : nlohmann::ordered_json(value.text);
    case KeyType::number:
      return value.number;
    case KeyType::text:
    case KeyType::path:
    case KeyType::choice:
      return value.text;
    case KeyType::integers:
      return value.integers;
    case KeyType::numbers:
      return value.numbers;
    case KeyType::number_or_numbers:
      return value.numbers.size() == 1 ? Json(value.number) : Json(value.numbers);
    case KeyType::texts:
    case KeyType::choices:
      return value.texts;
    case KeyType::points: {
      Json out = Json::array();
      for (const auto& [x, y] : value.points) out.push_back({x, y});
      return out;
    }
    case KeyType::text_map: {
      Json out = Json::object();
      for (const auto& [key, entry] : value.map) out[key] = entry.text;
      return out;
    }
    case KeyType::tables: {
      Json out = Json::array();
      for (const auto& record : value.records) out.push_back(record_json(record));
      return out;
    }
    case KeyType::table:
    case KeyType::path_or_table:
      return value.records.empty() ? Json(value.text) : record_json(value.records.front());
    case KeyType::commands:
      break;  // of studies alone
  }
  return {};
}

}  // namespace

std::string number_text(double value) {
  if (std::isnan(value)) return "nan";
  constexpr double kMostDigits = 1e15;  // counts and metres are read in digits: 50000000, not 5e+07
  const bool whole = value == std::round(value) && std::abs(value) < kMostDigits;
  char buffer[32];
  const auto end = whole ? std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed).ptr
                         : std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

std::string short_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

bool in_range(const KeySpec& spec, double value, const base::Where& where, base::Problems& problems) {
  const Bound low = parse_bound(spec.low), high = parse_bound(spec.high);
  const bool below = !low.open && (low.exclusive ? !(value > low.value) : !(value >= low.value));
  const bool above = !high.open && (high.exclusive ? !(value < high.value) : !(value <= high.value));
  if (std::isfinite(value) && !below && !above) return true;
  const std::string range = range_text(spec);
  const std::string unit = spec.unit.empty() ? "" : " " + std::string(spec.unit);
  const std::string word = spec.type == KeyType::integer_or_word ? " or \"" + std::string(spec.shape) + "\"" : "";
  problems.add(
      where, "'" + std::string(spec.key) + "' is " + (std::isfinite(value) ? "out of range" : "not a finite number"),
      number_text(value), range.empty() ? "give a finite number" + unit : "give a number " + range + unit + word);
  return false;
}

void fill_default(const KeySpec& spec, Value& value) {
  if (!spec.has_default()) return;
  const std::string_view text = spec.fallback;
  switch (spec.type) {
    case KeyType::boolean:
      value.boolean = text == "true";
      break;
    case KeyType::integer:
      std::from_chars(text.data(), text.data() + text.size(), value.integer);
      break;
    case KeyType::integer_or_word:
      if (std::from_chars(text.data(), text.data() + text.size(), value.integer).ec != std::errc()) value.text = text;
      break;
    case KeyType::number:
      std::from_chars(text.data(), text.data() + text.size(), value.number);
      break;
    case KeyType::numbers:
    case KeyType::number_or_numbers:
      value.numbers = parse_list(text);
      if (value.numbers.size() == 1) value.number = value.numbers.front();
      break;
    case KeyType::integers:
      for (const double number : parse_list(text)) value.integers.push_back(static_cast<std::int64_t>(number));
      break;
    default:
      value.text = text;
      break;
  }
}

void fill_defaults(Record& record, base::Problems* problems) {
  for (const auto& spec : option_keys()) {
    if (spec.table != record.path) continue;
    Value& value = record.values[std::string(spec.key)];
    if (value.given) {
      for (auto& sub : value.records) {
        fill_defaults(sub, problems);
        if (spec.type != KeyType::tables && !sub.sound) record.sound = false;
      }
      continue;
    }
    value.where = record.where;
    if (spec.type == KeyType::table && spec.has_default()) {
      Record& sub = value.records.emplace_back();
      sub.path = sub_path(spec);
      sub.where = record.where;
      fill_defaults(sub, problems);
      continue;
    }
    fill_default(spec, value);
    // The top level's format is checked file by file.
    if (!spec.required() || (record.path.empty() && spec.key == "format")) continue;
    record.sound = false;
    if (problems != nullptr)
      problems->add(record.where, "'" + std::string(spec.key) + "' is missing in [" + record.path + "]", "",
                    std::string(spec.text));
  }
}

const Value& Record::value(std::string_view key) const {
  const auto found = values.find(key);
  if (found == values.end())
    throw base::Error(base::Fault::bug, "option table has no key '" + std::string(key) + "' in [" + path + "]");
  return found->second;
}

bool Record::given(std::string_view key) const { return value(key).given; }

const base::Where& Record::place(std::string_view key) const { return value(key).where; }

const Record* Record::table(std::string_view key) const {
  const auto& list = value(key).records;
  return list.empty() ? nullptr : &list.front();
}

std::string value_text(const Record& record, std::string_view key) {
  const nlohmann::ordered_json values = record_json(record);
  const auto found = values.find(key);
  return found == values.end() ? "" : found->dump();
}

std::string document_json(const Record& root) { return record_json(root).dump(2); }

namespace {

bool plain_name(const std::string& name) {
  static constexpr std::string_view kAllowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  return name.find_first_not_of(kAllowed) == std::string::npos;
}

}  // namespace

void check_file_name(const Record& record, const char* key, const std::string& name, base::Problems& problems) {
  if (!plain_name(name))
    problems.add(record.place(key), "it becomes the name of a file", "'" + name + "'", "use letters, digits, _ and -");
}

void check_folder_name(const Record& record, const std::string& of, base::Problems& problems) {
  const std::string& name = record.text("name");
  if (!plain_name(name))
    problems.add(record.place("name"), of + "'s name is a folder's", "'" + name + "'", "use letters, digits, _ and -");
}

}  // namespace raycube::scene
