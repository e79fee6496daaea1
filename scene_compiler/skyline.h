// How steeply the ground rises around each place of it: rays that leave more steeply miss it without being traced.
#pragma once

#include <cstddef>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// The skyline of the scene's ground: of the trees that are placed once, by a matrix that keeps angles, the one whose
/// gentle triangles cover most, at least half of its bounds; empty where there is none. Cells (frame of the tree, up =
/// +z) hold two numbers:
///
///     top      no triangle of the ground is higher within the cell, m
///     skyline  square of the tangent of an elevation that no triangle of the ground exceeds as seen from any point of
///              it within the cell: z_q - z_p <= sqrt(skyline) |q_xy - p_xy|, for all p in the cell and q of the ground
///
/// so that a ray that leaves the ground there, or any place of the cell above `top`, more steeply than the skyline
/// meets nothing of the ground. INFINITY past kSteepSkyline, and where nothing is known: within a cell or more of an
/// edge of the ground, a wall, a fold, a second layer. Elsewhere the ground is one continuous function of place over
/// the square of 3, 5 or 9 cells round it, so that nothing in there rises more steeply than the triangles' planes (its
/// edges are sewn to each other in pairs there, and one layer covers the middle of each cell); beyond, cells are
/// compared by their least and greatest heights. Skylines are 2 % higher than that, for what single precision rounds.
/// The same for any number of threads, and of edges that are sorted at once (24 bytes each; a third of all is taken
/// where that is more, since each time costs a pass over all triangles).
Skyline survey_skyline(const CompiledScene& scene, int threads, std::size_t edges_at_once = std::size_t{1} << 22);

/// Above that, rays would leave their surface no more steeply than its own points are lifted off it
/// (kernels/geometry/lift.h).
constexpr float kSteepSkyline = 0.75f;

}  // namespace raycube::scene
