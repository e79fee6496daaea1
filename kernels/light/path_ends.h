/* Where rays of paths ended, and how light goes on from there: of paths from a viewer (bounce.h) and from a source
 * (entry/trace_photons.cl). Nothing here knows a wavelength. */
#ifndef RAYCUBE_KERNELS_LIGHT_PATH_ENDS_H
#define RAYCUBE_KERNELS_LIGHT_PATH_ENDS_H

#include "kernels/geometry/any_hits16.h"
#include "kernels/geometry/surface_side.h"
#include "kernels/light/far_side.h"
#include "kernels/materials/shapes.h"
#include "kernels/sampling/sky_rays.h"

/* Where rays ended. */
typedef struct Ends16 {
  float front[3][16], back[3][16]; /* m, scene frame: off the surface on the side that the ray came from, and beyond */
  float normal[3][16];             /* unit, to the side that the ray came from */
  float lift[16];                  /* m: that front was moved along the normal, more than rounding can be */
  uint instance[16], primitive[16], surface[16];
  uint lit; /* bit of each that sees the sun */
} RC_LINE Ends16;

static inline void rc_store3(Vector16 v, float to[3][16]) {
  rc_store16(v.x, 0, to[0]);
  rc_store16(v.y, 0, to[1]);
  rc_store16(v.z, 0, to[2]);
}
static inline float4 rc_lane_of(float from[3][16], uint k) {
  return (float4)(from[0][k], from[1][k], from[2][k], 0.0f);
}
static inline float4 rc_way_of(const Rays16* rays, uint k) {
  return (float4)(rays->dx[k], rays->dy[k], rays->dz[k], 0.0f);
}

/* How many times Lambert's radiance goes to `out` of light from `in` on the near side. */
static inline float rc_shape_factor(global const Lobe* lobes, uint surface, float4 normal, float4 in, float4 out) {
#if RC_SHAPED
  const Lobe lobe = lobes[surface * RC_LOBE_STRIDE];
  if (lobe.shape != RC_SHAPE_lambert)
    return rc_shape_eval(lobe.shape, 3.14159265f, rc_parameters(lobes, lobe), rc_angles(normal, in, out));
#endif
  return 1.0f;
}

#if RC_GLOSSY
/* The gloss of a surface: materials mixed in it share one. Its shape is RC_SHAPE_none where it has none. */
static inline Lobe rc_gloss_of(global const Lobe* lobes, uint surface) {
  Lobe lobe = lobes[surface * RC_LOBE_STRIDE + 1u];
  for (uint i = 2; i < RC_LOBE_BEHIND; ++i)
    if (!(lobe.share > 0.0f)) lobe = lobes[surface * RC_LOBE_STRIDE + i];
  return lobe;
}

/* How many times Lambert's radiance goes from `in` to `out` by a gloss. */
static inline float rc_gloss_factor(global const Lobe* lobes, Lobe gloss, float4 normal, float4 in, float4 out) {
  return rc_shape_eval(gloss.shape, 3.14159265f, rc_parameters(lobes, gloss), rc_angles(normal, in, out));
}

/* Direction by the gloss of a surface for u and v uniform in [0, 1): half mirrored at its facets, half by the cosine.
 * weight: times its form, how much more than by Lambert's law; 0 where it points into the surface. */
static inline float4 rc_way_mirrored(global const Lobe* lobes, Lobe gloss, float4 normal, float4 out, float u, float v,
                                     float* weight) {
  const SkyDensity cosine = {1.0f, 0.0f, 0.5f, 0.0f, 0.0f, 1.0f};
  const float alpha = rc_shape_roughness(gloss.shape, rc_parameters(lobes, gloss));
  const SkyRay ray = rc_mirrored_way(cosine, alpha, u, v, normal.x, normal.y, normal.z, out.x, out.y, out.z);
  const float4 way = (float4)(ray.x, ray.y, ray.z, 0.0f);
  const float density = RC_GLOSS_SHARE * rc_facets_pdf(alpha, rc_angles(normal, out, way)) +
                        (1.0f - RC_GLOSS_SHARE) * rc_sky_density(cosine, ray.x, ray.y, ray.z, ray.facing);
  *weight = ray.facing > 0.0f ? 0.318309886f * ray.facing / density : 0.0f;
  return way;
}
#endif

/* Direction by the cosine about the side that light goes on from, for u and v uniform in [0, 1). normal: of the side
 * that the ray came to; came: its direction. shaped: how many times Lambert's radiance goes there. */
static inline float4 rc_way_on(global const Lobe* lobes, uint surface, bool through, float4 normal, float4 came,
                               float u, float v, float* shaped) {
  const float4 about = through ? -normal : normal;
  float c, s, x, y, z;
  rc_turn(v, &c, &s);
  rc_about(about.x, about.y, about.z, sqrt(1.0f - u), c, s, &x, &y, &z);
  const float4 way = (float4)(x, y, z, 0.0f);
  *shaped = through ? 1.0f : rc_shape_factor(lobes, surface, normal, way, -came);
  return way;
}

/* Points and normals where the live rays ended; every lane's hit is valid or a copy of one that is. */
__attribute__((noinline)) static void rc_stand(SceneArrays scene, global const Lobe* lobes, const Rays16* rays,
                                               uint live, Ends16* ends) {
  float corner[9][16];
  uint leaves = 0;
  const uint first = rc_lowest(live);
  for (uint k = 0; k < 16u; ++k) {
    if (!(live >> k & 1u)) ends->instance[k] = ends->instance[first], ends->primitive[k] = ends->primitive[first];
    const uint primitive = ends->primitive[k];
    global const float* at = (global const float*)rc_block(scene, primitive / RC_BLOCK) + primitive % RC_BLOCK;
    for (uint c = 0; c < 9u; ++c) corner[c][k] = at[16u * c];
    ends->surface[k] = rc_surface_of(scene, primitive);
    leaves |= rc_is_leaf(lobes, ends->surface[k]) || rc_is_plate(lobes, ends->surface[k]) ? 1u << k : 0u;
  }
  Vector16 v[3];
  for (uint c = 0; c < 3u; ++c) {
    v[c].x = rc_load16(0, corner[3u * c]);
    v[c].y = rc_load16(0, corner[3u * c + 1u]);
    v[c].z = rc_load16(0, corner[3u * c + 2u]);
  }
  const Vector16 origin = {rc_load16(0, rays->x), rc_load16(0, rays->y), rc_load16(0, rays->z)};
  const Vector16 way = {rc_load16(0, rays->dx), rc_load16(0, rays->dy), rc_load16(0, rays->dz)};
  const Vector16 backwards = {-way.x, -way.y, -way.z};
  SurfaceSide16 front, back;
  rc_clear_side(&front);
  rc_clear_side(&back);
  uint left = live;
  while (left) {
    const uint instance = ends->instance[rc_lowest(left)];
    const int16 lanes = rc_load16(0, ends->instance) == instance;
    left &= ~rc_mask16(lanes);
    rc_find_side(rc_instance(scene, instance), v, origin, way, lanes, &front);
    if (rc_mask16(lanes) & leaves) rc_find_side(rc_instance(scene, instance), v, origin, backwards, lanes, &back);
  }
  rc_store3(front.position, ends->front);
  rc_store3(front.normal, ends->normal);
  rc_store16(front.lift, 0, ends->lift);
  rc_store3(back.position, ends->back);
}

#endif
