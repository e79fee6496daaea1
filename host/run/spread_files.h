// What a camera's focal planes do to its image, for its folder: how sharp each band is, and where each looks.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/base/output_file.h"
#include "host/sensors/cells.h"

namespace raycube::run {

/// Adds mtf.csv (transfer of each band at 0 to 1 cycles a pixel, as it is and as the file asks for) and, where anything
/// looks beside its place or smiles, registration.img (lines: bands; samples: pixels; how far each looks across and
/// along from where it should, pixels, and its centre's shift, nm). Names and what they hold.
std::vector<std::pair<std::string, std::string>> add_spread_files(const sensors::Cells& cells, base::OutputSet& set);

/// For run.json: cells a pixel, margin, largest errors of the transfer.
std::string spread_json(const sensors::Cells& cells);

}  // namespace raycube::run
