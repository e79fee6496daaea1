// What a scattering shape does with all the light that falls onto it: integrals over directions, for a curve of 1. By
// the midpoint rule, to 2e-3 of it.
#pragma once

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// Share of light from one direction that leaves (black-sky albedo); the shape is of role front.
double black_sky_albedo(const Shape& shape, double zenith_rad);

/// Share of light of an even sky that leaves (white-sky albedo); 1 by Lambert's law.
double white_sky_albedo(const Shape& shape);

/// The largest black-sky albedo, and for light from where: looked for up to 80 degrees from the normal; 1 of shapes
/// that conserve energy whatever their parameters.
struct MostAlbedo {
  double albedo = 1, zenith_deg = 0;
};
MostAlbedo most_albedo(const Shape& shape);
/// The same of what a material reflects at a wavelength, over its reflectance there.
MostAlbedo most_albedo(const Material& material, double wavelength_um);

/// How many times the radiance of Lambert's law goes into the brightest direction, both up to 80 degrees from the
/// normal.
double brightest_direction(const Shape& shape);

}  // namespace raycube::scene
