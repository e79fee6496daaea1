// Which triangles share a block of 16.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "scene_compiler/bvh_tree.h"

namespace raycube::scene::detail {

/// The order in which triangles with these boxes fill blocks of RC_BLOCK one after the other, so that only the last
/// block may have room left. Ranges are cut in two where the surface area of both boxes, each times the blocks that it
/// holds, is least (MacDonald & Booth, "Heuristics for ray tracing using space subdivision", Vis. Comput. 6, 1990),
/// until a range fills one block; there the boxes' own order stands. The same order everywhere, for any number of
/// threads. Precondition: finite boxes.
std::vector<std::uint32_t> block_order(std::uint32_t count, const std::function<Box(std::uint32_t)>& box_of);
std::vector<std::uint32_t> block_order(const std::vector<Box>& boxes);

}  // namespace raycube::scene::detail
