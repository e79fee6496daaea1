// Rows of a reference file below $RAYCUBE_SHARED/reference/atmosphere, by column label.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace raycube::testing {

using AnchorRow = std::map<std::string, double>;

/// Lines that start with # are notes; empty cells are left out; a cell that is no number reads 0. Empty, with a loud
/// word about what was not shown, when RAYCUBE_SHARED is not set. Throws std::runtime_error when the file is not there
/// or has no rows.
std::vector<AnchorRow> anchor_rows(const std::string& file, const std::string& not_shown);

}  // namespace raycube::testing
