// Helpers of document.cpp that need no TOML: ranges, defaults, texts of numbers.
#pragma once

#include "scene_compiler/document.h"

namespace raycube::scene {

/// Shortest text that reads back as the same double, whole numbers below 1e15 in digits; "nan", "inf".
std::string number_text(double value);
/// Three figures, for what was computed.
std::string short_text(double value);
/// Reports NaN, infinity and values outside the table's range; true when sound.
bool in_range(const KeySpec& spec, double value, const base::Where& where, base::Problems& problems);
/// The table's default into value (given stays as it is).
void fill_default(const KeySpec& spec, Value& value);
/// Defaults of every key of the record's table and of its sub-tables. Missing required keys go to problems
/// unless null.
void fill_defaults(Record& record, base::Problems* problems);
/// Report a name that no folder or file can have: what of letters, digits, _ and - is not. of: "an instrument".
void check_file_name(const Record& record, const char* key, const std::string& name, base::Problems& problems);
void check_folder_name(const Record& record, const std::string& of, base::Problems& problems);

}  // namespace raycube::scene
