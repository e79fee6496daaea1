#include "host/experiment/result_files.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/experiment/study_table.h"

namespace raycube::experiment {
namespace {

using Json = nlohmann::json;
using Conditions = std::vector<std::pair<std::string, std::string>>;

/// A number that is all of the text.
std::optional<double> number_of(const std::string& text) {
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc() && end.ptr == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(' ');
  return from == std::string::npos ? "" : text.substr(from, text.find_last_not_of(' ') - from + 1);
}

/// Parts of a place between its slashes, with ~1 and ~0 read (RFC 6901); nothing: no place. A slash inside of [ ] is no
/// boundary.
std::optional<std::vector<std::string>> parts_of(const std::string& place) {
  std::vector<std::string> out;
  bool in_brackets = false;
  for (std::size_t i = 0; i < place.size(); ++i) {
    const char c = place[i];
    if (c == '/' && !in_brackets) {
      out.emplace_back();
      continue;
    }
    if (out.empty()) return std::nullopt;
    in_brackets = c == '[' || (in_brackets && c != ']');
    if (c != '~' || in_brackets) {
      out.back() += c;
      continue;
    }
    if (++i == place.size() || (place[i] != '0' && place[i] != '1')) return std::nullopt;
    out.back() += place[i] == '0' ? '~' : '/';
  }
  return out;
}

/// What name[key=value, ...] asks for, and the name before it; none: a name alone.
std::optional<Conditions> conditions_of(const std::string& part, std::string& name) {
  name = part;
  const std::size_t open = part.find('[');
  if (open == std::string::npos || part.back() != ']') return std::nullopt;
  Conditions out;
  const std::string inside = part.substr(open + 1, part.size() - open - 2);
  for (std::size_t at = 0; at <= inside.size();) {
    const std::size_t comma = std::min(inside.find(',', at), inside.size());
    const std::string one = inside.substr(at, comma - at);
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos) return std::nullopt;
    out.emplace_back(trimmed(one.substr(0, equals)), trimmed(one.substr(equals + 1)));
    at = comma + 1;
  }
  name = part.substr(0, open);
  return out;
}

/// Numbers are the same to rounding, as they are when one was computed and the other typed.
bool meets(const Json& value, const std::string& wanted) {
  if (value.is_string()) return value.get<std::string>() == wanted;
  if (value.is_boolean()) return wanted == (value.get<bool>() ? "true" : "false");
  const std::optional<double> number = number_of(wanted);
  return value.is_number() && number &&
         std::abs(value.get<double>() - *number) <= 1e-12 * std::max(std::abs(*number), std::abs(value.get<double>()));
}

bool meets(const Json& element, const Conditions& conditions) {
  for (const auto& [key, wanted] : conditions)
    if (!element.is_object() || !element.contains(key) || !meets(element.at(key), wanted)) return false;
  return true;
}

std::string shown(const Json& value) {
  if (value.is_number()) return fmt::format("{}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// The values that the conditions' keys have in a list, for messages.
std::string values_there(const Json& list, const Conditions& conditions) {
  constexpr std::size_t kMost = 12;
  std::string out;
  for (std::size_t i = 0; i < list.size() && i < kMost; ++i) {
    std::string one;
    for (const auto& [key, wanted] : conditions)
      if (list[i].is_object() && list[i].contains(key))
        one += (one.empty() ? "" : ", ") + key + "=" + shown(list[i].at(key));
    out += (out.empty() ? "[" : " [") + (one.empty() ? "none of these keys" : one) + "]";
  }
  return list.size() > kMost ? out + fmt::format(" and {} more", list.size() - kMost) : out;
}

/// Whether the file is a sweep's, whose lists have another order as soon as its levels are others.
bool is_sweep(const Json& file) {
  return file.is_object() && file.contains("method") && file.contains("parameters") && file.contains("points");
}

/// One step down; null: nothing is there. `found`: why, if there is more to say.
const Json* child(const Json& from, const std::string& part, std::string& why) {
  if (from.is_object() && from.contains(part)) return &from.at(part);
  std::string name;
  const auto conditions = conditions_of(part, name);
  if (conditions) {
    const Json* list = name.empty() ? &from : from.is_object() && from.contains(name) ? &from.at(name) : nullptr;
    if (!list || !list->is_array()) return nullptr;
    const Json* found = nullptr;
    std::size_t count = 0;
    for (const Json& element : *list)
      if (meets(element, *conditions)) found = &element, ++count;
    if (count == 1) return found;
    why = fmt::format(": {} elements of {} are so; there are {}", count, name, values_there(*list, *conditions));
    return nullptr;
  }
  const bool digits = !part.empty() && part.size() < 10 && part.find_first_not_of("0123456789") == std::string::npos;
  if (!from.is_array() || !digits || (part.size() > 1 && part[0] == '0')) return nullptr;
  const auto index = static_cast<std::size_t>(std::stoul(part));
  return index < from.size() ? &from[index] : nullptr;
}

}  // namespace

void check_place(StudyTable& table, const std::string& key, const std::string& place) {
  if (!parts_of(place))
    table.problem(key, "no place in a JSON file", "'" + place + "'",
                  "begin with /, as in /curves/0/area (RFC 6901), or name an element, as in /points[snr=50]/found");
}

const nlohmann::json& ResultFiles::at(const std::string& path, const std::string& place, const std::string& where) {
  const auto [file, fresh] = files_.try_emplace(path);
  if (fresh) {
    std::ifstream in(path);
    if (!in) throw base::Error(base::Fault::input, where + ": " + path + " is not there; is its step among the steps?");
    file->second = nlohmann::json::parse(in, nullptr, false);
  }
  if (file->second.is_discarded())
    throw base::Error(base::Fault::input, where + ": " + path + " is no JSON (which has no NaN)");
  const Json* found = &file->second;
  std::string why;
  const std::vector<std::string> parts = parts_of(place).value_or(std::vector<std::string>());
  for (const std::string& part : parts) {
    const Json* next = child(*found, part, why);
    if (next && found->is_array() && next->is_object() && is_sweep(file->second) && number_of(part))
      throw base::Error(
          base::Fault::input,
          fmt::format("{}: {} counts elements of a sweep's lists (found number {} in {}), and other "
                      "levels have other numbers; name them, as in /points[{}=VALUE, ...]/METRIC",
                      where, place, part, path, file->second.at("parameters").at(0).at("name").get<std::string>()));
    found = next;
    if (!found) break;
  }
  if (!found) throw base::Error(base::Fault::input, where + ": " + path + " has nothing at " + place + why);
  return *found;
}

}  // namespace raycube::experiment
