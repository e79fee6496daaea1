/* Shapes other than Lambert's, seen by cameras: how much of what falls onto a sample from one direction goes to the
 * viewer (kernels/materials). Compiled in where a material of the scene has one (RC_SHAPED). */
#ifndef RAYCUBE_KERNELS_LIGHT_SPREAD_H
#define RAYCUBE_KERNELS_LIGHT_SPREAD_H

#include "kernels/sampling/sky_rays.h"
#include "kernels/shared/tile_layout.h"

#if RC_SHAPED
#include "kernels/materials/shapes.h"

/* How many times the radiance of Lambert's law goes to the viewer: pi f. at: the sample's slot in the planes of
 * surface; direction: unit, to where light comes from. */
static inline float rc_spread(global const Lobe* lobes, global const float* at, float4 direction) {
  const uint number = as_uint(at[RC_PLANE(RC_LOBE_AT)]);
  if (number == 0u) return 1.0f;
  const Lobe lobe = lobes[number - 1u];
  if (lobe.shape == RC_SHAPE_lambert) return 1.0f;
  const float4 normal = (float4)(at[RC_PLANE(RC_NORMAL_X)], at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)], 0.0f);
  const float4 viewer = (float4)(at[RC_PLANE(RC_VIEWER_X)], at[RC_PLANE(RC_VIEWER_Y)], at[RC_PLANE(RC_VIEWER_Z)], 0.0f);
  return rc_shape_eval(lobe.shape, 3.14159265f, rc_parameters(lobes, lobe), rc_angles(normal, direction, viewer));
}

#if RC_FURTHER
/* Whether the slot at `at` is of a further lobe whose light comes by `side`: its shape has the role of that side's. */
static inline bool rc_is_further(global const Lobe* lobes, global const float* at, uint side) {
  const uint number = as_uint(at[RC_PLANE(RC_LOBE_AT)]);
  if (number == 0u) return false;
  return side == (rc_shape_role(lobes[number - 1u].shape) == RC_ROLE_gloss ? RC_GLOSS_SIDE : RC_NEAR_SIDE);
}
#endif

/* Of a word of samples, those in `lanes`; else 1. */
static inline float16 rc_spread16(global const Lobe* lobes, global const float* at, float4 direction, uint lanes) {
  float spread[16];
  for (uint k = 0; k < 16u; ++k) spread[k] = lanes >> k & 1u ? rc_spread(lobes, at + k, direction) : 1.0f;
  return vload16(0, spread);
}
#endif

/* Of a sample's further lobes whose light comes by `side`, `scale` times that; of others 0. at: the pixel's planes of
 * surface; slot: of the sample's side; direction: where light comes from. */
static inline void rc_further_factors(const TileShape* tile, global const Lobe* lobes, global const float* at,
                                      uint slot, uint side, float4 direction, float scale, float* more) {
#if RC_FURTHER
  for (uint number = 0; number < tile->further; ++number) {
    global const float* here =
        at + rc_surface_slot(rc_slot_of_side(tile, rc_sample_of(tile, slot), RC_FURTHER_SIDE + number));
    more[number] = rc_is_further(lobes, here, side) ? scale * rc_spread(lobes, here, direction) : 0.0f;
  }
#endif
}

/* Ray `number` of a pixel from what a sample's slot stands for; at: the slot in the planes of surface. */
static inline SkyRay rc_slot_ray(SkyDensity law, uint seed, uint pixel, uint number, bool gloss,
                                 global const Lobe* lobes, global const float* at) {
  const float nx = at[RC_PLANE(RC_NORMAL_X)], ny = at[RC_PLANE(RC_NORMAL_Y)], nz = at[RC_PLANE(RC_NORMAL_Z)];
#if RC_GLOSSY
  if (gloss) {
    /* Where there is none, the normal is zero, and nothing faces it. */
    const Lobe lobe = lobes[max(as_uint(at[RC_PLANE(RC_LOBE_AT)]), 1u) - 1u];
    const RcParameters p = rc_parameters(lobes, lobe);
    const float vx = at[RC_PLANE(RC_VIEWER_X)], vy = at[RC_PLANE(RC_VIEWER_Y)], vz = at[RC_PLANE(RC_VIEWER_Z)];
    const float alpha = rc_shape_roughness(lobe.shape, p);
    SkyRay ray = rc_gloss_way(law, alpha, seed, pixel, number, nx, ny, nz, vx, vy, vz);
    const RcAngles angles =
        rc_angles((float4)(nx, ny, nz, 0.0f), (float4)(vx, vy, vz, 0.0f), (float4)(ray.x, ray.y, ray.z, 0.0f));
    ray.density = RC_GLOSS_SHARE * rc_facets_pdf(alpha, angles) +
                  (1.0f - RC_GLOSS_SHARE) * rc_sky_density(law, ray.x, ray.y, ray.z, ray.facing);
    return ray;
  }
#endif
  return rc_sky_ray(law, seed, pixel, number, nx, ny, nz);
}

#endif
