// [[measure]] entries.
#pragma once

#include <string>
#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Every measure, checked.
std::vector<Measure> read_measures(const Record& root, base::Problems& problems);

/// Name of the instrument whose bands a [[measure]] or [[budget]] has; empty after reporting.
std::string banded_instrument(const Record& record, const std::vector<Record>& instruments, base::Problems& problems);

}  // namespace raycube::scene
