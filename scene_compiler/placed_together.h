// Which meshes can share a tree.
#pragma once

#include <cstdint>
#include <vector>

#include "scene_compiler/scene_builder.h"

namespace raycube::scene {

/// Groups of meshes that always stand together: placed equally often, each time by the same matrix, and each time the
/// same number of places apart in the user's list (so that one number tells a triangle's owner in every placed tree,
/// owner.h). Everything that is placed once and unmoved, terrains, planes and boxes among it, is one group; bark and
/// leaves listed at the same places are another. A mesh that is placed like no other, or never, is alone.
///
/// Every mesh is in one group, in the order of their first placements; groups in the order of their lowest meshes.
std::vector<std::vector<std::uint32_t>> placed_together(const std::vector<Placed>& placed, std::size_t mesh_count);

}  // namespace raycube::scene
