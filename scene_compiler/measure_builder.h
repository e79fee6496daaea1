// [[measure]] entries.
#pragma once

#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Every measure, checked.
std::vector<Measure> read_measures(const Record& root, base::Problems& problems);

}  // namespace raycube::scene
