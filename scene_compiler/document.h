// A simulation file and its includes as typed, range-checked records with defaults filled in: what the option
// table says and no more. toml++ stays inside document.cpp and document_overrides.cpp.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/option_table.h"

namespace raycube::scene {

struct Record;
struct NamedValue;

struct Value {
  bool given = false;  ///< false: the default of the table
  base::Where where;
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0;
  std::string text;  ///< text, choice; path: resolved against the folder of the file that names it
  std::vector<double> numbers;
  std::vector<std::int64_t> integers;
  std::vector<std::string> texts;
  std::vector<base::Where> text_places;  ///< of each text
  std::vector<std::pair<double, double>> points;
  std::vector<NamedValue> map;  ///< text_map, in file order
  std::vector<Record> records;  ///< tables; a table is one record
};

/// An entry of a text_map.
struct NamedValue {
  std::string name;
  Value value;
};

/// One table of the file. Getters return the default (or zero, when the table gives none) of a key that was
/// not given.
struct Record {
  std::string path;
  base::Where where;
  bool sound = true;  ///< false: something in it was reported; do not build from it
  std::map<std::string, Value, std::less<>> values;

  bool given(std::string_view key) const;
  const base::Where& place(std::string_view key) const;  ///< of the key, or of the table when it was not given
  bool boolean(std::string_view key) const { return value(key).boolean; }
  std::int64_t integer(std::string_view key) const { return value(key).integer; }
  double number(std::string_view key) const { return value(key).number; }
  const std::string& text(std::string_view key) const { return value(key).text; }
  const std::vector<double>& numbers(std::string_view key) const { return value(key).numbers; }
  const std::vector<std::int64_t>& integers(std::string_view key) const { return value(key).integers; }
  const Value& value(std::string_view key) const;
  /// Records of a tables key, or the one of a table key; empty when not given.
  const std::vector<Record>& records(std::string_view key) const { return value(key).records; }
  /// The sub-table, or nullptr.
  const Record* table(std::string_view key) const;
};

/// Reads a file and everything it includes. Syntax, unknown keys, types, ranges and cycles go to `problems`;
/// what is sound is returned all the same, so that later stages can find more problems in the same run.
/// overrides: KEY=VALUE in place of what the files say (document_overrides.h).
Record read_document(const std::string& file, base::Problems& problems, const std::vector<std::string>& overrides = {});

/// What the file gives for one key of the record, or its default, as JSON on one line.
std::string value_text(const Record& record, std::string_view key);

/// The record and its sub-tables with every option of the table, defaults included, as JSON.
std::string document_json(const Record& root);

}  // namespace raycube::scene
