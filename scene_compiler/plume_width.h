// Widths of a plume: the one law for its box, its flattening and what a LIDAR reaches of it.
#pragma once

#include <cmath>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// sigma = a x / sqrt(1 + b x) of Briggs, or a constant; m, x_m downwind of the source.
inline double plume_sigma_m(double x_m, double a, double b, double constant_m) {
  return constant_m > 0 ? constant_m : a * x_m / std::sqrt(1 + b * x_m);
}
/// Where a plume ends, across and above its axis, at its far end: RC_PLUME_WIDTHS sigmas.
inline double plume_side_m(const Volume& plume) {
  return double{RC_PLUME_WIDTHS} * plume_sigma_m(plume.length_m, plume.sigma_y_a, plume.sigma_y_b, plume.sigma_y_m);
}
inline double plume_rise_m(const Volume& plume) {
  return double{RC_PLUME_WIDTHS} * plume_sigma_m(plume.length_m, plume.sigma_z_a, plume.sigma_z_b, plume.sigma_z_m);
}

}  // namespace raycube::scene
