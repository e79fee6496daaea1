// [[budget]] entries.
#pragma once

#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Every budget, checked.
std::vector<LightBudget> read_budgets(const Record& root, base::Problems& problems);

}  // namespace raycube::scene
