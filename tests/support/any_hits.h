// Rays in directions of their own that ask whether anything lies ahead: sixteen at a time through the trees, one by one
// through the trees, and one by one against every triangle.
#pragma once

#include <cstdint>
#include <vector>

#include "host/cl/kernel.h"
#include "host/render/scene_buffers.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::test {

/// Rays in the scene's frame: origin (m) and direction of ray i.
struct AnyRays {
  std::vector<float> x, y, z, dx, dy, dz;
};

/// Bit k: something lies ahead of ray k of the sixteen. one_way: as rays of one direction go through a tree together;
/// without_tree where they do not all have one.
struct AnyAnswers {
  std::uint32_t together = 0, alone = 0, without_tree = 0, one_way = 0;
};

/// Of sixteens of rays, one after the other, the first 1 + i % 16 of sixteen i are asked about. rays: a multiple of 16.
std::vector<AnyAnswers> any_hits(const cl::Context& context, const scene::CompiledScene& scene, const AnyRays& rays);

}  // namespace raycube::test
