// Whether single precision can hold a scene's parts where they stand.
#pragma once

#include "scene_compiler/scene_builder.h"

namespace raycube::scene {

/// How far off its surface a shadow ray starts at a place, m: the error bound of
/// kernels/geometry/surface_point.h, 16 roundings (2^-24) of the sum of the coordinates' sizes, for a mesh
/// placed by a matrix. Places are rounded to a 16th of that.
double shadow_start_m(double x_m, double y_m, double z_m);

/// Refuses meshes that are placed so far from the scene's origin that half of their extent is lost in that;
/// where it is past a tenth of the median over their triangles of the longest side, a notice names the worst
/// placement.
void check_kept_places(SceneParts& parts, base::Problems& problems);

}  // namespace raycube::scene
