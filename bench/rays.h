// Rays and their comparison, for every group of figures.
#pragma once

#include <vector>

#include "bench/embree_baseline.h"
#include "scene_compiler/simulation.h"

namespace raycube::bench {

/// The instrument's samples on the given groups, as the kernels place them (grid and lattice of pixel 0).
PrimaryRays primary_rays(const scene::Instrument& instrument, const std::vector<shared::RayGroup>& groups);

/// Share of rays whose instance or primitive differ.
double differing(const std::vector<RayResult>& a, const std::vector<RayResult>& b);
/// Share of rays that hit in one and miss in the other.
double hit_or_miss(const std::vector<RayResult>& a, const std::vector<RayResult>& b);

/// Triangles per pixel that can hold one of the instrument's samples: [group * width + i].
std::vector<std::uint32_t> candidates(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                      const std::vector<shared::RayGroup>& groups, int threads);
double mean(const std::vector<std::uint32_t>& counts);

}  // namespace raycube::bench
