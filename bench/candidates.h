// How many triangles a pixel has to look at: a slow, separate count in double that shares nothing with the kernels.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/shared/structs.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::bench {

/// Triangles, over all instances, whose projection overlaps the square of half width `half_px` (pixels) about a pixel's
/// centre: separating planes are the square's four and the triangle's three edges through the origin. With half_px
/// reaching to the outermost sample these are the triangles that can hold a sample. pixel = group * width + i. Held
/// poses only (ov is not looked at).
std::vector<std::uint32_t> count_candidates(const scene::CompiledScene& scene,
                                            const std::vector<shared::RayGroup>& groups, int width, double half_px,
                                            int threads);

}  // namespace raycube::bench
