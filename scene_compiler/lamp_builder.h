// [[lamp]] entries.
#pragma once

#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/lamp.h"
#include "scene_compiler/scene_builder.h"

namespace raycube::scene {

/// Every lamp with its files, checked. Lamps whose spectra are not the same number at most kMostLampSpectra spectra.
std::vector<Lamp> read_lamps(const Record& root, const SceneParts& parts, base::Problems& problems);

/// Each is a source of its own beside sun and sky.
inline constexpr int kMostLampSpectra = 4;

}  // namespace raycube::scene
