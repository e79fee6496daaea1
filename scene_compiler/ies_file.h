// Photometric files of luminaires: IES LM-63 (1986 to 2019), type C.
#pragma once

#include <optional>
#include <string>

#include "host/base/error.h"
#include "scene_compiler/lamp.h"

namespace raycube::scene {

/// Intensities with ballast and multiplier factors, without those for tilted lamps; horizontal angles from 0 to
/// 360 deg. nullopt after reporting what is wrong.
std::optional<LampDistribution> read_ies(const std::string& file, const base::Where& asked_by,
                                         base::Problems& problems);

}  // namespace raycube::scene
