// Rows of a reference file below $RAYCUBE_SHARED/reference/atmosphere, by column label.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace raycube::testing {

using AnchorCells = std::map<std::string, std::string>;
using AnchorRow = std::map<std::string, double>;

/// The cells' text. Lines that start with # are notes. Empty, with a loud word about what was not shown, when
/// RAYCUBE_SHARED is not set. Throws std::runtime_error when the file is not there or has no rows.
std::vector<AnchorCells> anchor_cells(const std::string& file, const std::string& not_shown);

/// The same as numbers: empty cells are left out; a cell that is no number reads 0.
std::vector<AnchorRow> anchor_rows(const std::string& file, const std::string& not_shown);

}  // namespace raycube::testing
