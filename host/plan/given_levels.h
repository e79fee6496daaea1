// Levels of a plan that the file gives: what no plan can have, whatever the air.
#pragma once

#include "host/base/error.h"
#include "scene_compiler/simulation.h"

namespace raycube::plan {

/// Throws Error(input): sky rays out of range; nodes of [plan] whose channels alone are more than a plan has, which
/// takes no table of the air to know.
void check_given_levels(const scene::Simulation& simulation);

/// That the levels of [plan] leave nothing to choose.
base::Error impossible_levels(const scene::Simulation& simulation);

}  // namespace raycube::plan
