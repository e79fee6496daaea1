// Closest hits of the tracing kernels, ray by ray, against brute force in double over the same fp32 rays.
#pragma once

#include <vector>

#include "tests/support/trace_chain.h"

namespace raycube::test {

/// A hit may differ from the double oracle only where the ray passes within this many units of 2^-24 (times the size of
/// the coordinates that entered) of an edge, or two surfaces lie that close in depth. 16 = the sum of the roundings of
/// the map into the mesh frame (4), the vertex difference (1), the direction (3), the shear (3) and the edge product
/// (3), rounded up.
inline constexpr double kBoundUlp = 16;

struct HitCount {
  std::size_t rays = 0, hits = 0;
  std::size_t explained = 0;  ///< differ from double within the bound
  std::size_t wrong = 0;      ///< differ beyond it; the first three are printed
};

HitCount judge_hits(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape,
                    const std::vector<shared::RayGroup>& groups);

}  // namespace raycube::test
