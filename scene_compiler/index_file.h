// Refractive indices by wavelength from a CSV.
#pragma once

#include <optional>
#include <string>

#include "host/base/error.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// n and k over vacuum wavelengths in um, strictly ascending, 0.05 to 1000; n > 0, k >= 0, both at most 1000.
struct RefractiveIndex {
  Curve n, k;
};

/// Columns wavelength_nm or wavelength_um, n, and k (0 without it). Null after reporting every problem.
std::optional<RefractiveIndex> read_index(const std::string& file, const base::Where& asked_by,
                                          base::Problems& problems);

}  // namespace raycube::scene
