// Docs and JSON schema made from the option table.
#include <nlohmann/json.hpp>

#include "scene_compiler/option_table.h"

namespace raycube::scene {
namespace {

using Json = nlohmann::ordered_json;

std::string_view type_name(KeyType type) {
  switch (type) {
    case KeyType::boolean:
      return "true or false";
    case KeyType::integer:
      return "integer";
    case KeyType::number:
      return "number";
    case KeyType::text:
      return "text";
    case KeyType::path:
      return "path";
    case KeyType::choice:
      return "choice";
    case KeyType::choices:
      return "list of choices";
    case KeyType::integers:
      return "integers";
    case KeyType::numbers:
      return "numbers";
    case KeyType::number_or_numbers:
      return "number or numbers";
    case KeyType::points:
      return "list of [x, y]";
    case KeyType::texts:
      return "texts";
    case KeyType::text_map:
      return "table of texts";
    case KeyType::table:
      return "table";
    case KeyType::tables:
      return "tables";
    case KeyType::path_or_table:
      return "path or table";
    case KeyType::integer_or_word:
      return "integer or word";
    case KeyType::commands:
      return "command or commands";
  }
  return "";
}

bool is_array_table(const FileFormat& format, std::string_view path) {
  const KeySpec* spec = find_key(format, "", path);
  return spec != nullptr && spec->type == KeyType::tables;
}

Json number_schema(const KeySpec& spec, const char* type) {
  Json out = {{"type", type}};
  const Bound low = parse_bound(spec.low), high = parse_bound(spec.high);
  if (!low.open) out[low.exclusive ? "exclusiveMinimum" : "minimum"] = low.value;
  if (!high.open) out[high.exclusive ? "exclusiveMaximum" : "maximum"] = high.value;
  return out;
}

Json list_schema(const KeySpec& spec, Json items) {
  Json out = {{"type", "array"}, {"items", std::move(items)}};
  if (spec.shape.empty()) return out;
  Json any = Json::array();
  for (std::size_t n = 1; n <= 16; ++n)
    if (shape_allows(spec, n)) any.push_back({{"minItems", n}, {"maxItems", n}});
  if (any.size() == 1) {
    out.update(any[0]);
  } else {
    out["anyOf"] = any;
  }
  return out;
}

Json choice_schema(const KeySpec& spec) {
  Json values = Json::array();
  std::string_view rest = spec.shape;
  while (!rest.empty()) {
    const auto bar = rest.find('|');
    values.push_back(std::string(rest.substr(0, bar)));
    rest = bar == std::string_view::npos ? std::string_view{} : rest.substr(bar + 1);
  }
  return {{"enum", values}};
}

Json table_schema(const FileFormat& format, std::string_view path);

Json key_schema(const FileFormat& format, const KeySpec& spec) {
  const Json text = {{"type", "string"}};
  const auto table = [&] { return table_schema(format, sub_path(spec)); };
  switch (spec.type) {
    case KeyType::boolean:
      return {{"type", "boolean"}};
    case KeyType::integer:
      return number_schema(spec, "integer");
    case KeyType::number:
      return number_schema(spec, "number");
    case KeyType::text:
    case KeyType::path:
      return text;
    case KeyType::choice:
      return choice_schema(spec);
    case KeyType::choices:
      return {{"type", "array"}, {"items", choice_schema(spec)}};
    case KeyType::integers:
      return list_schema(spec, number_schema(spec, "integer"));
    case KeyType::numbers:
      return list_schema(spec, number_schema(spec, "number"));
    case KeyType::number_or_numbers: {
      const Json number = number_schema(spec, "number");
      return {{"anyOf", Json::array({number, list_schema(spec, number)})}};
    }
    case KeyType::points:
      return {
          {"type", "array"},
          {"items", {{"type", "array"}, {"items", number_schema(spec, "number")}, {"minItems", 2}, {"maxItems", 2}}}};
    case KeyType::texts:
      return list_schema(spec, text);
    case KeyType::text_map:
      return {{"type", "object"}, {"additionalProperties", text}};
    case KeyType::table:
      return table();
    case KeyType::tables: {
      const Json list = {{"type", "array"}, {"items", table()}};
      if (spec.table.empty() && !format.one_for_list) return list;
      return {{"if", {{"type", "object"}}}, {"then", table()}, {"else", list}};
    }
    case KeyType::integer_or_word:
      return {{"anyOf", Json::array({number_schema(spec, "integer"), {{"enum", Json::array({spec.shape})}}})}};
    case KeyType::path_or_table:
      return {{"anyOf", Json::array({text, table()})}};
    case KeyType::commands: {
      const Json command = {{"type", "array"}, {"items", text}};
      return {{"type", "array"}, {"items", {{"anyOf", Json::array({text, command})}}}, {"minItems", 1}};
    }
  }
  return {};
}

Json default_value(const KeySpec& spec) {
  switch (spec.type) {
    case KeyType::boolean:
    case KeyType::integer:
    case KeyType::number:
      return Json::parse(spec.fallback);
    case KeyType::integer_or_word:
      return spec.fallback == spec.shape ? Json(std::string(spec.fallback)) : Json::parse(spec.fallback);
    case KeyType::integers:
    case KeyType::numbers:
      return Json::parse("[" + std::string(spec.fallback) + "]");
    case KeyType::table:
      return Json::object();
    default:
      return std::string(spec.fallback);
  }
}

Json table_schema(const FileFormat& format, std::string_view path) {
  Json properties = Json::object(), required = Json::array();
  for (const auto& spec : format.keys) {
    if (spec.table != path) continue;
    Json one = key_schema(format, spec);
    std::string text(spec.text);
    if (!spec.unit.empty()) text += " Unit: " + std::string(spec.unit) + ".";
    one["description"] = text;
    if (spec.has_default()) one["default"] = default_value(spec);
    properties[std::string(spec.key)] = std::move(one);
    if (spec.required()) required.push_back(std::string(spec.key));
  }
  Json out = {{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  if (required.empty()) return out;
  if (!properties.contains("sensor")) {
    out["required"] = required;
    return out;
  }
  // A sensor's file says what the instrument's own table does not, but its name.
  std::erase(required.get_ref<Json::array_t&>(), Json("name"));
  out["required"] = Json::array({"name"});
  out["anyOf"] = Json::array({{{"required", required}}, {{"required", Json::array({"sensor"})}}});
  return out;
}

/// What a key may be: choices, or range and number of values.
std::string allowed_text(const KeySpec& spec) {
  if (spec.type == KeyType::choice || spec.type == KeyType::choices) return choices_text(spec);
  const std::string range = range_text(spec);
  if (spec.shape.empty()) return range;
  std::string lengths(spec.shape);
  if (const auto last = lengths.rfind('|'); last != std::string::npos) lengths.replace(last, 1, " or ");
  for (auto bar = lengths.find('|'); bar != std::string::npos; bar = lengths.find('|')) lengths.replace(bar, 1, ", ");
  return range + (range.empty() ? "" : "; ") +
         (spec.type == KeyType::integer_or_word ? "or \"" + lengths + "\"" : lengths + " values");
}

}  // namespace

std::string options_json(const FileFormat& format) {
  Json tables = Json::array();
  for (const auto& table : format.tables) {
    Json keys = Json::array();
    for (const auto& spec : format.keys) {
      if (spec.table != table.path) continue;
      Json key = {{"key", spec.key}, {"type", type_name(spec.type)}, {"required", spec.required()}};
      if (!spec.unit.empty()) key["unit"] = spec.unit;
      if (spec.has_default()) key["default"] = default_value(spec);
      if (const std::string allowed = allowed_text(spec); !allowed.empty()) key["range"] = allowed;
      key["meaning"] = spec.text;
      keys.push_back(std::move(key));
    }
    tables.push_back({{"table", table.path}, {"meaning", table.text}, {"keys", std::move(keys)}});
  }
  return Json{{"tables", std::move(tables)}}.dump(2) + "\n";
}

std::string options_json_schema(const FileFormat& format) {
  Json out = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", format.title}};
  out.update(table_schema(format, ""));
  return out.dump(2) + "\n";
}

std::string options_markdown(const FileFormat& format) {
  std::string out;
  for (const auto& table : format.tables) {
    const std::string path(table.path);
    std::string title = path.empty()                   ? "Top level"
                        : is_array_table(format, path) ? "`[[" + path + "]]`"
                                                       : "`[" + path + "]`";
    if (path.find('.') != std::string::npos && is_array_table(format, path.substr(0, path.find('.'))))
      title = "`" + path.substr(path.find('.') + 1) + " = { ... }` of `[[" + path.substr(0, path.find('.')) + "]]`";
    out += "### " + title + "\n\n" + std::string(table.text) + "\n\n";
    out += "| key | type | unit | default | range | meaning |\n|---|---|---|---|---|---|\n";
    for (const auto& spec : format.keys) {
      if (spec.table != table.path) continue;
      const std::string fallback = spec.required()      ? "required"
                                   : spec.has_default() ? "`" + std::string(spec.fallback) + "`"
                                                        : "";
      out += "| `" + std::string(spec.key) + "` | " + std::string(type_name(spec.type)) + " | " +
             std::string(spec.unit) + " | " + fallback + " | " + allowed_text(spec) + " | " + std::string(spec.text) +
             " |\n";
    }
    out += "\n";
  }
  return out;
}

}  // namespace raycube::scene
