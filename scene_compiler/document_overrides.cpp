#include "scene_compiler/document_overrides.h"

#include "scene_compiler/csv_file.h"

#include <algorithm>
#include <optional>

namespace raycube::scene {
namespace {

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> out{""};
  for (const char c : text) {
    if (c == '.')
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

std::optional<toml::table> parsed_value(const std::string& text) {
  try {
    return toml::parse("value = " + text);
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

/// The entry that has this name, or this number.
toml::table* entry(toml::array& list, const std::string& which) {
  for (toml::node& node : list)
    if (auto* table = node.as_table())
      if (const auto name = (*table)["name"].value<std::string>(); name && *name == which) return table;
  const bool number =
      !which.empty() && std::all_of(which.begin(), which.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!number || which.size() > 6 || std::stoul(which) >= list.size()) return nullptr;
  return list.get(std::stoul(which))->as_table();
}

toml::table* follow(toml::table& from, const std::vector<std::string>& way, std::size_t first) {
  toml::table* at = &from;
  for (std::size_t i = first; i < way.size() && at; ++i) {
    toml::node* next = at->get(way[i]);
    if (!next) return nullptr;
    if (auto* list = next->as_array())
      at = ++i < way.size() ? entry(*list, way[i]) : nullptr;
    else
      at = next->as_table();
  }
  return at;
}

}  // namespace

Overrides::Overrides(const std::vector<std::string>& texts, base::Problems& problems) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    One one;
    one.text = text;
    one.way = parts_of(trimmed(text.substr(0, equals)));
    const bool empty =
        std::any_of(one.way.begin(), one.way.end(), [](const std::string& part) { return part.empty(); });
    if (equals == std::string::npos || equals + 1 == text.size() || empty) {
      problems.add({"--set", 0, 0, ""}, "wants KEY=VALUE", "'" + text + "'", "as in atmosphere.visibility_km=12");
      continue;
    }
    one.key = one.way.back(), one.way.pop_back();
    const std::string value = text.substr(equals + 1);
    if (auto holder = parsed_value(value))
      one.holder = std::move(*holder);
    else
      one.holder.insert("value", value);
    all_.push_back(std::move(one));
  }
}

void Overrides::apply(toml::table& table, const std::string& prefix) {
  const std::vector<std::string> before = prefix.empty() ? std::vector<std::string>{} : parts_of(prefix);
  for (One& one : all_) {
    if (one.used || one.way.size() < before.size() || !std::equal(before.begin(), before.end(), one.way.begin()))
      continue;
    toml::table* to = follow(table, one.way, before.size());
    if (!to) continue;
    // A key of a sensor's file stays there; what neither has goes to the table of the file itself.
    one.holder.get("value")->visit([&](const auto& value) { to->insert_or_assign(one.key, value); });
    one.used = true;
  }
}

void Overrides::report_unused(const std::string& file, base::Problems& problems) const {
  for (const One& one : all_) {
    if (one.used) continue;
    std::string table;
    for (const std::string& part : one.way) table += (table.empty() ? "" : ".") + part;
    problems.add(
        {"--set", 0, 0, ""}, file + " has no table '" + table + "'", "'" + one.text + "'",
        "write it into the file, or name an entry of a list by its name or number: instrument.spectir.pixels=9");
  }
}

}  // namespace raycube::scene
