// What the scene shows from straight above: vertical rays through its trees, on the host, in double.
#pragma once

#include "scene_compiler/compiled_scene.h"

namespace raycube::plan {

/// Index in scene.surfaces of the uppermost triangle at (x, y), m, scene frame, of several at one height of the user's
/// first; RC_NONE where a vertical line meets none.
std::uint32_t uppermost_surface(const scene::CompiledScene& scene, double x_m, double y_m);

}  // namespace raycube::plan
