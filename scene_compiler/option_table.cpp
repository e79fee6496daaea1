#include "scene_compiler/option_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <vector>

namespace raycube::scene {
namespace {

/// What `band_truth` may name.
constexpr char kBandTruthNames[] = "parts"
#define RC_BAND_TRUTH(name, kind, unit, text) "|" #name
#include "scene_compiler/band_truth.def"
#undef RC_BAND_TRUTH
    ;

constexpr auto kKeys = [] {
  using enum KeyType;
  return std::to_array<KeySpec>({
#define RC_TABLE(path, text)
#define RC_KEY(table, key, type, unit, fallback, low, high, shape, text) \
  {table, key, type, unit, fallback, low, high, shape, text},
#include "scene_compiler/keys.def"
#undef RC_TABLE
#undef RC_KEY
  });
}();

constexpr auto kTables = std::to_array<TableSpec>({
#define RC_TABLE(path, text) {path, text},
#define RC_KEY(table, key, type, unit, fallback, low, high, shape, text)
#include "scene_compiler/keys.def"
#undef RC_TABLE
#undef RC_KEY
});

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const auto bar = text.find('|');
    parts.push_back(text.substr(0, bar));
    text = bar == std::string_view::npos ? std::string_view{} : text.substr(bar + 1);
  }
  return parts;
}

/// Levenshtein distance.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

/// Whether all words of `key`, apart by underscores, stand in `whole` in their order.
bool has_words(std::string_view whole, std::string_view key) {
  std::size_t from = 0;
  const std::string in = "_" + std::string(whole) + "_";
  while (!key.empty()) {
    const std::size_t end = std::min(key.find('_'), key.size());
    const std::size_t at = in.find("_" + std::string(key.substr(0, end)) + "_", from);
    if (at == std::string::npos) return false;
    from = at + 1 + end;
    key.remove_prefix(std::min(end + 1, key.size()));
  }
  return true;
}

constexpr std::string_view kInstrument = "instrument";

/// Path of an instrument's table in its sensor's file; nothing: of no instrument.
std::optional<std::string_view> in_sensor(std::string_view path) {
  if (path == kInstrument) return "";
  if (!path.starts_with(kInstrument) || path[kInstrument.size()] != '.') return std::nullopt;
  return path.substr(kInstrument.size() + 1);
}

std::vector<KeySpec> sensor_keys() {
  std::vector<KeySpec> out = {*find_key("", "format")};
  for (KeySpec spec : kKeys) {
    const auto table = in_sensor(spec.table);
    if (!table || (table->empty() && is_instruments_own(spec.key))) continue;
    spec.table = *table;
    if (spec.table.empty() && spec.required()) spec.fallback = "";  // the instrument itself may say it
    out.push_back(spec);
  }
  return out;
}

std::vector<TableSpec> sensor_tables() {
  std::vector<TableSpec> out;
  for (TableSpec table : kTables) {
    const auto path = in_sensor(table.path);
    if (!path) continue;
    table.path = *path;
    if (path->empty())
      table.text = "Top level: what an [[instrument]] that names the file as its `sensor` does not say itself.";
    out.push_back(table);
  }
  return out;
}

}  // namespace

std::span<const KeySpec> option_keys() { return kKeys; }
std::span<const TableSpec> option_tables() { return kTables; }

const FileFormat& simulation_format() {
  static const FileFormat format = {"raycube simulation file", kKeys, kTables, false};
  return format;
}

const FileFormat& sensor_format() {
  static const std::vector<KeySpec> keys = sensor_keys();
  static const std::vector<TableSpec> tables = sensor_tables();
  static const FileFormat format = {"raycube sensor file", keys, tables};
  return format;
}

bool is_instruments_own(std::string_view key) { return key == "name" || key == "sensor"; }

const KeySpec* find_key(std::string_view table, std::string_view key) {
  return find_key(simulation_format(), table, key);
}

const KeySpec* find_key(const FileFormat& format, std::string_view table, std::string_view key) {
  const auto found = std::find_if(format.keys.begin(), format.keys.end(),
                                  [&](const KeySpec& spec) { return spec.table == table && spec.key == key; });
  return found == format.keys.end() ? nullptr : &*found;
}

std::string nearest_key(const FileFormat& format, std::string_view table, std::string_view key) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, key.size() / 3) + 1;
  for (const auto& spec : format.keys) {
    if (spec.table != table) continue;
    // A key typed without its unit ("altitude" for "altitude_agl_m") is as near as a typing slip.
    // So is one without a word in its middle ("altitude_m").
    const bool part = key.size() > 2 && (spec.key.starts_with(key) || has_words(spec.key, key));
    const std::size_t distance = part ? 1 : edit_distance(key, spec.key);
    if (distance < best_distance) best_distance = distance, best = spec.key;
  }
  return best;
}

std::string sub_path(const KeySpec& spec) {
  return spec.table.empty() ? std::string(spec.key) : std::string(spec.table) + "." + std::string(spec.key);
}

Bound parse_bound(std::string_view text) {
  Bound bound;
  if (text.empty()) return bound;
  bound.open = false;
  bound.exclusive = text[0] == '>' || text[0] == '<';
  if (bound.exclusive) text.remove_prefix(1);
  std::from_chars(text.data(), text.data() + text.size(), bound.value);
  return bound;
}

std::string range_text(const KeySpec& spec) {
  const Bound low = parse_bound(spec.low), high = parse_bound(spec.high);
  const auto bare = [](std::string_view text) {
    return std::string(text.starts_with('>') || text.starts_with('<') ? text.substr(1) : text);
  };
  if (low.open && high.open) return "";
  if (high.open) return (low.exclusive ? "> " : ">= ") + bare(spec.low);
  if (low.open) return (high.exclusive ? "< " : "<= ") + bare(spec.high);
  if (low.value == high.value) return bare(spec.low);
  if (!low.exclusive && !high.exclusive) return bare(spec.low) + " .. " + bare(spec.high);
  return (low.exclusive ? "> " : ">= ") + bare(spec.low) + " and " + (high.exclusive ? "< " : "<= ") + bare(spec.high);
}

std::string choices_text(const KeySpec& spec) {
  std::string out;
  for (const auto part : split(spec.shape)) out += (out.empty() ? "" : ", ") + std::string(part);
  return out;
}

bool shape_allows(const KeySpec& spec, std::size_t length) {
  const auto parts = split(spec.shape);
  return parts.empty() ||
         std::any_of(parts.begin(), parts.end(), [&](auto part) { return part == std::to_string(length); });
}

bool is_choice(const KeySpec& spec, std::string_view value) {
  const auto parts = split(spec.shape);
  return std::find(parts.begin(), parts.end(), value) != parts.end();
}

}  // namespace raycube::scene
