// The option tables of files as data, and what is made from them: docs and JSON schema. Those of the simulation file
// (keys.def) and of a sensor's file are here, those of studies in host/experiment/study_keys.h.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace raycube::scene {

enum class KeyType {
  boolean,
  integer,
  number,
  text,
  path,
  choice,
  choices,  ///< a list of them
  integers,
  numbers,
  number_or_numbers,  ///< a number is a list of one
  points,
  texts,
  text_map,
  table,
  tables,
  path_or_table,
  integer_or_word,
  commands  ///< a list of texts, or a list of such lists
};

struct KeySpec {
  std::string_view table;  ///< "" = top level
  std::string_view key;
  KeyType type;
  std::string_view unit;
  std::string_view fallback;   ///< "!" required, "" none
  std::string_view low, high;  ///< "" open, ">x" or "<x" exclusive
  std::string_view shape;      ///< choices "a|b", or allowed lengths "1|3", or the word
  std::string_view text;

  bool required() const { return fallback == "!"; }
  bool has_default() const { return !fallback.empty() && !required(); }
};

struct TableSpec {
  std::string_view path;
  std::string_view text;
};

/// A bound of a number; value is meaningless when open.
struct Bound {
  bool open = true, exclusive = false;
  double value = 0;
};

/// What a kind of file may say.
struct FileFormat {
  std::string_view title;  ///< "raycube simulation file"
  std::span<const KeySpec> keys;
  std::span<const TableSpec> tables;
  bool one_for_list = true;  ///< [x] is as good as [[x]] at the top level, as it is inside tables
};

const FileFormat& simulation_format();
/// Of a file that an instrument names as its `sensor`: the keys of [[instrument]], none required, but those of
/// is_instruments_own.
const FileFormat& sensor_format();
/// Keys of [[instrument]] that its sensor's file cannot say.
bool is_instruments_own(std::string_view key);

std::span<const KeySpec> option_keys();
std::span<const TableSpec> option_tables();
/// The row of a key, or nullptr.
const KeySpec* find_key(std::string_view table, std::string_view key);
const KeySpec* find_key(const FileFormat& format, std::string_view table, std::string_view key);
/// Known key of that table with the smallest edit distance (at most a third of its length, at least 2), or
/// "".
std::string nearest_key(const FileFormat& format, std::string_view table, std::string_view key);
/// Path of the table that a table key opens: "instrument.bands".
std::string sub_path(const KeySpec& spec);
Bound parse_bound(std::string_view text);
/// "0 .. 1", "> 0", "" as docs and messages write a range.
std::string range_text(const KeySpec& spec);
/// "a|b" split.
std::string choices_text(const KeySpec& spec);
bool shape_allows(const KeySpec& spec, std::size_t length);
bool is_choice(const KeySpec& spec, std::string_view value);

/// One Markdown section per table; of simulation files those of docs/scene_format.md between its "generated" marks.
std::string options_markdown(const FileFormat& format);
/// The same as JSON: a list of tables with their keys, each with type, unit, default, range and meaning.
std::string options_json(const FileFormat& format);
/// JSON Schema (draft 2020-12) of such a file.
std::string options_json_schema(const FileFormat& format);

}  // namespace raycube::scene
