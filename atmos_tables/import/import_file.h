// Any file of another code, told apart by its name and first lines.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// The names a user may give: "tape7", "7sc", "tape6", "chn", "json", "csv", "acd", "acd-binary", "uvspec", "6s",
/// "plain-csv".
const std::vector<std::string>& format_names();

/// `format`: one of format_names(), or empty to tell by the file. `uvspec_input`: as in read_uvspec.
Imported import_file(const std::string& path, const std::string& format = {}, const std::string& uvspec_input = {});

/// What was read, for people and as JSON.
std::string imported_text(const Imported& imported);
std::string imported_json(const Imported& imported);

}  // namespace raycube::atmos::imported
