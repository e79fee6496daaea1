// Reflectance and transmittance of a leaf from what it holds: PROSPECT-D (Feret et al. 2017, Remote Sensing of
// Environment 193, 204-215).
#pragma once

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// What a leaf is made of, per area of leaf.
struct LeafContent {
  double structure = 1.5;         ///< N: plates that scatter like its mesophyll, at least 1
  double chlorophyll_ug_cm2 = 0;  ///< a + b
  double carotenoids_ug_cm2 = 0;
  double anthocyanins_ug_cm2 = 0;
  double brown = 0;  ///< brown pigments, arbitrary unit
  double water_cm = 0;
  double dry_matter_g_cm2 = 0;
};

struct LeafOptics {
  Curve reflectance, transmittance;  ///< directional-hemispherical, light within 40 degrees of the leaf's normal
};

/// 0.4 to 2.5 um by 1 nm; wavelengths, in air where its constants were measured, are turned to vacuum, and the first is
/// 0.4 um. The leaf is N plates of absorption k = sum of contents times specific absorptions, over N; one plate's
///   tau = (1 - k) exp(-k) + k^2 E1(k)
/// of diffuse light (Allen et al. 1969, J. Opt. Soc. Am. 59, 1376), its faces by Stern's mean of Fresnel's law over a
/// cone (Allen 1973, J. Opt. Soc. Am. 63, 664), all plates by Stokes's pile (1862). Errors against measured leaves 1 to
/// 3 % absolute (Feret et al. 2017, table 5); against PyPI prosail 2.0.5 1e-6 (test `leaf_optics`).
LeafOptics leaf_optics(const LeafContent& leaf);

/// Mean transmissivity of the face of matter of this refractive index, light from within a cone about its normal of
/// this half angle (rad, at most pi/2).
double mean_face_transmissivity(double half_angle_rad, double refractive_index);

}  // namespace raycube::scene
