// [[atmosphere.own_aerosol]] entries.
#pragma once

#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Every aerosol of the user's own, its files read and what contradicts itself reported. What follows from physics
/// (wavelengths covered, phase functions above 0) is checked where the air is made (atmos_tables/aerosol).
std::vector<OwnAerosolSpec> read_own_aerosols(const Record& atmosphere, base::Problems& problems);

}  // namespace raycube::scene
