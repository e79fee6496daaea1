/* Paths' beginnings: from the samples of a group of pixels, sixteen first rays at a time; and their ends, as what the
 * pixels gain. */
#ifndef RAYCUBE_KERNELS_LIGHT_PATH_START_H
#define RAYCUBE_KERNELS_LIGHT_PATH_START_H

#include "kernels/light/bounce.h"
#include "kernels/light/spread.h"

/* Follows what waits and adds it path by path, in their order: a sum does not depend on who waited together. */
static inline void rc_add_paths(SceneArrays scene, const PathTables* t, Paths16* paths, global float* out) {
  for (uint k = paths->count; k < 16u; ++k)
    rc_put_ray(&paths->rays, k, (float4)(0.0f), (float4)(0.0f, 0.0f, 1.0f, 0.0f));
  rc_follow(scene, t, paths);
  for (uint k = 0; k < paths->count; ++k) {
    global float* to = out + rc_glow_at(t->tile, paths->pixel[k], paths->part[k]);
    for (uint m = 0; m < rc_glow_width(t->tile); ++m) to[m] = fma(paths->scale[k], paths->gained[k][m], to[m]);
  }
  paths->count = 0, paths->live = 0;
}

/* Paths whose first rays wait to be asked whether they meet anything: most see sky, whose light is scattered once. */
typedef struct First16 {
  Rays16 rays;
  float weight[16]; /* of the side and direction by which the path begins: by the cosine 1 over the side's chance */
  float scale[16];  /* as of Paths16 */
  uint pixel[16], part[16], path[16];
  uint slot[16], surface[16], side[16]; /* of the sample */
  uint sample[16];                      /* of the pixel */
  uint count;
  uint down, clear; /* bits of rays that go below the horizon; that are known to miss the ground */
#if RC_PLATES
  float over_chance[16]; /* 1 over the side's chance */
  uint straight, none; /* bits of rays through a plate; of paths that have no ray, since it would go into the surface */
  uint sunless;        /* of slots that face a sun that they do not see */
#endif
} First16;

static inline void rc_clear_first(First16* first) {
  first->count = first->down = first->clear = 0;
#if RC_PLATES
  first->straight = first->none = first->sunless = 0;
#endif
}

/* 1 over the chance of the side that a path leaves. near: chance of the near side of what gloss leaves. */
static inline float rc_over_chance(uint side, float near, float gloss) {
  return side == RC_GLOSS_SIDE ? 1.0f / gloss
         : side == RC_FAR_SIDE ? 1.0f / ((1.0f - near) * (1.0f - gloss))
                               : 1.0f / (near * (1.0f - gloss));
}

#if RC_PLATES
/* Marks what plates make of path i, and sends it straight on where it goes through one. at: its slot in the planes of
 * surface, lift: how far that lies off the surface; lit: the slot sees the sun. */
static inline void rc_put_first_plate(const PathTables* t, First16* first, uint i, bool straight,
                                      global const float* at, float lift, bool lit, SkyRay* ray, float4* point) {
  const float4 normal = (float4)(at[RC_PLANE(RC_NORMAL_X)], at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)], 0.0f);
  if (straight) {
    /* As far behind the surface, and the roundings of both. */
    const float4 behind = fma((float4)(-2.25f * lift), normal, *point);
    *point = behind - copysign(fabs(behind) * (4.0f * RC_ULP), normal);
    ray->x = -at[RC_PLANE(RC_VIEWER_X)];
    ray->y = -at[RC_PLANE(RC_VIEWER_Y)];
    ray->z = -at[RC_PLANE(RC_VIEWER_Z)];
    first->straight |= 1u << i;
    return;
  }
  if (!(ray->facing > 0.0f)) first->none |= 1u << i;
  if (t->tile->sun && t->sun_up && !lit && rc_dot3(normal, t->sun) > 0.0f) first->sunless |= 1u << i;
}

/* Sunlight that comes to where a path begins through plates alone, and goes to the viewer by the side that the path
 * leaves; added to what is gained, [skeleton]. at: the pixel's planes of surface. False: there is none. */
__attribute__((noinline)) static bool rc_gain_first_sun(SceneArrays scene, const PathTables* t, const First16* first,
                                                        uint i, global const float* at, float* gained) {
  const uint slot = first->slot[i], side = first->side[i], surface = first->surface[i];
  global const float* here = at + rc_surface_slot(slot);
  const float4 point =
      (float4)(here[RC_PLANE(RC_POINT_X)], here[RC_PLANE(RC_POINT_Y)], here[RC_PLANE(RC_POINT_Z)], 0.0f);
  const float4 normal =
      (float4)(here[RC_PLANE(RC_NORMAL_X)], here[RC_PLANE(RC_NORMAL_Y)], here[RC_PLANE(RC_NORMAL_Z)], 0.0f);
  Rays16 rays;
  for (uint k = 0; k < 16u; ++k) rc_put_ray(&rays, k, point, t->sun);
  float let[RC_SKELETON], more[1 + RC_FURTHER];
  if (!rc_behind_plates(scene, t, &rays, 0u, let)) return false;
  float factor = rc_dot3(normal, t->sun) * first->over_chance[i];
  rc_further_factors(t->tile, t->lobes, at, slot, side, t->sun, factor, more);
  if (side != RC_FAR_SIDE) factor *= rc_spread(t->lobes, here, t->sun);
  rc_carry_on(scene, t, surface, side, factor, more, let, let);
  for (uint m = 0; m < t->tile->skeleton; m += RC_WORD)
    rc_add16(vload16(0, t->source_share + m), vload16(0, let + m), gained + m);
  return true;
}
#endif

/* Lets the paths that wait begin, in their order, if their first rays meet anything. in: surface points of the group's
 * first pixel; first_number: that pixel's. */
static inline void rc_begin_paths(SceneArrays scene, const PathTables* t, uint ground, First16* first,
                                  uint first_number, global const float* in, global float* out, Paths16* paths) {
  const uint asked = ((1u << first->count) - 1u) & ~first->down;
  Rays16 rays = first->rays;
  const uint hidden = first->down | (asked ? rc_hidden_of(scene, &rays, asked, ground, first->clear) : 0u);
#if RC_PLATES
  const uint straight = first->straight, none = first->none, begin = hidden | first->sunless;
#else
  const uint straight = 0u, none = 0u, begin = hidden;
#endif
  for (uint i = 0; t->log_paths && i < first->count; ++i) {
    global PathStep* at = rc_step(t, first->pixel[i], first->path[i], 0u);
    rc_log_ray(at, &first->rays, i, first->weight[i], first->scale[i]);
    at->slot = first->sample[i] * 4u + first->side[i];
    at->decided |= hidden >> i & 1u ? RC_STEP_MET : 0u;
  }
  for (uint left = begin; left; left &= left - 1u) {
    const uint i = rc_lowest(left);
    const uint k = paths->count;
    const float4 way = rc_way_of(&first->rays, i);
    rc_put_ray(&paths->rays, k, (float4)(first->rays.x[i], first->rays.y[i], first->rays.z[i], 0.0f), way);
    paths->number[k] = first_number + first->pixel[i], paths->path[k] = first->path[i];
    float unit[RC_SKELETON], factor = first->weight[i], more[1 + RC_FURTHER];
    for (uint m = 0; m < t->tile->skeleton; m += RC_WORD) vstore16((float16)(1.0f), 0, unit + m);
    global const float* points = in + rc_surface_at(t->tile, first->pixel[i]);
    rc_further_factors(t->tile, t->lobes, points, first->slot[i], first->side[i], way, factor, more);
#if RC_SHAPED
    if (first->side[i] != RC_FAR_SIDE) factor *= rc_spread(t->lobes, points + rc_surface_slot(first->slot[i]), way);
#endif
    rc_carry_on(scene, t, first->surface[i], first->side[i], factor, more, unit, paths->carried[k]);
    for (uint m = 0; m < rc_glow_width(t->tile); m += RC_WORD) vstore16((float16)(0.0f), 0, paths->gained[k] + m);
    bool passed = false, lit = false;
    const bool follow = (hidden & ~none) >> i & 1u, meets = follow && rc_meets(scene, t, paths, k, 0u, &passed);
    if (t->log_paths) {
      global PathStep* at = rc_step(t, first->pixel[i], first->path[i], 0u);
      at->instance = paths->ends.instance[k], at->primitive = paths->ends.primitive[k];
    }
#if RC_PLATES
    if (first->sunless >> i & 1u) lit = rc_gain_first_sun(scene, t, first, i, points, paths->gained[k]);
#endif
    /* What comes straight from the sky was scattered once. */
    passed = passed || straight >> i & 1u;
    if (!meets && !lit && (!follow || (way.z > 0.0f && !passed))) continue;
    paths->reach[k] = first->side[i] == RC_GLOSS_SIDE ? 1.0f : t->scattering[first->surface[i]].y;
    paths->pixel[k] = first->pixel[i], paths->part[k] = first->part[i];
    paths->scale[k] = first->scale[i];
    if (meets)
      paths->live |= 1u << k;
    else if (follow && !(way.z > 0.0f))
      rc_gain_ground(t, k, paths);
    else if (passed)
      rc_gain_sky(t, k, paths);
    if (++paths->count == 16u) rc_add_paths(scene, t, paths, out);
  }
  rc_clear_first(first);
}

#endif
