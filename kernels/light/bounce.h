/* Paths of light from surface to surface (docs/light.md, Light between surfaces): sixteen side by side, from the
 * surfaces that pixels see on. Along a path goes what its viewer would see of a unit that comes back, at the skeleton
 * wavelengths; where a path stands, the sun and the sky add to what it gains. Decisions know no wavelength. */
#ifndef RAYCUBE_KERNELS_LIGHT_BOUNCE_H
#define RAYCUBE_KERNELS_LIGHT_BOUNCE_H

#include "kernels/geometry/any_hits16.h"
#include "kernels/light/heat.h"
#include "kernels/light/path_log.h"
#include "kernels/light/path_matter.h"
#include "kernels/light/plates.h"
#include "kernels/sampling/sky_rays.h"

#if RC_GLOSSY
/* Adds light that falls onto a side from a direction and goes back by the surface's gloss; gained: of its source. */
static inline void rc_gain_mirrored(SceneArrays scene, const PathTables* t, uint surface, float4 normal, float4 in,
                                    float4 out, float irradiance, const float* share, const float* carried,
                                    float* gained) {
  if (!rc_glossy(t, surface)) return;
  float light[RC_SKELETON], more[1 + RC_FURTHER];
  rc_more_factors(t, surface, RC_GLOSS_SIDE, normal, in, out, irradiance, more);
  rc_carry_on(scene, t, surface, RC_GLOSS_SIDE,
              irradiance * rc_gloss_factor(t->lobes, rc_gloss_of(t->lobes, surface), normal, in, out), more, carried,
              light);
  for (uint m = 0; m < t->tile->skeleton; m += RC_WORD)
    rc_add16(share ? vload16(0, share + m) : (float16)(1.0f), vload16(0, light + m), gained + m);
}
#endif

/* The next two, and rc_stand, are not inlined: made into one function with rc_follow, PoCL 3.1 (LLVM 15) builds a
 * kernel that does not end. Why is not known.
 * Sunlight on the ends of the live paths. */
__attribute__((noinline, unused)) static void rc_gain_sun(SceneArrays scene, const PathTables* t, uint live,
                                                          Ends16* ends, Paths16* paths) {
  Rays16 rays;
  uint of[16], side[16], count = 0;
  float cosine[16];
  for (; live; live &= live - 1u) {
    const uint k = rc_lowest(live);
    const float facing = rc_dot3(rc_lane_of(ends->normal, k), t->sun);
    if (!(facing > 0.0f) && !(facing < 0.0f && rc_is_leaf(t->lobes, ends->surface[k]))) continue;
    of[count] = k, side[count] = facing > 0.0f ? 0u : 1u, cosine[count] = fabs(facing);
    rc_put_ray(&rays, count++, rc_lane_of(facing > 0.0f ? ends->front : ends->back, k), t->sun);
  }
  if (!count) return;
  const uint hidden = rc_first_hidden(scene, &rays, count, RC_NONE, 0u);
  for (uint i = 0; i < count; ++i) {
    const uint k = of[i];
    float let[RC_SKELETON];
    if (hidden >> i & 1u && !rc_let_by_plates(scene, t, &rays, i, let)) continue;
    ends->lit |= 1u << k;
    float factor = cosine[i], more[1 + RC_FURTHER];
    const float4 normal = rc_lane_of(ends->normal, k), back = -rc_way_of(&paths->rays, k);
    rc_more_factors(t, ends->surface[k], side[i], normal, t->sun, back, factor, more);
    if (side[i] == 0u) factor *= rc_shape_factor(t->lobes, ends->surface[k], normal, t->sun, back);
    float light[RC_SKELETON];
    rc_carry_on(scene, t, ends->surface[k], side[i], factor, more, paths->carried[k], light);
    float share[RC_SKELETON];
    for (uint m = 0; m < t->tile->skeleton; m += RC_WORD) {
      float16 sun = vload16(0, t->source_share + m);
      if (RC_PLATES && hidden >> i & 1u) sun *= vload16(0, let + m);
      vstore16(sun, 0, share + m);
      rc_add16(sun, vload16(0, light + m), paths->gained[k] + m);
    }
#if RC_GLOSSY
    if (side[i] == 0u) {
      rc_gain_mirrored(scene, t, ends->surface[k], normal, t->sun, back, cosine[i], share, paths->carried[k],
                       paths->gained[k]);
    }
#endif
  }
}

/* Lamplight on the ends of the live paths: one lamp of each source for each side that light goes on from. */
__attribute__((noinline)) static void rc_gain_lamps(SceneArrays scene, const PathTables* t, uint live, uint level,
                                                    Ends16* ends, Paths16* paths) {
  for (; live; live &= live - 1u) {
    const uint k = rc_lowest(live), surface = ends->surface[k], number = paths->number[k], path = paths->path[k];
    const float4 normal = rc_lane_of(ends->normal, k), front = rc_lane_of(ends->front, k);
    const float4 point = front - ends->lift[k] * normal;
    const uint sides = rc_is_leaf(t->lobes, surface) ? 2u : 1u, lamps = t->tile->lamps;
    for (uint i = 0; i < sides * lamps; ++i) {
      const uint side = i / lamps, source = i % lamps, draw = RC_LAMP_DRAW + 3u * i;
      const float4 from = side == 0u ? front : rc_lane_of(ends->back, k);
      const LampDraw lamp = rc_draw_lamp(
          &t->lamps, source, point, side == 0u ? normal : -normal, rc_path_draw(t, number, path, level, draw),
          rc_path_draw(t, number, path, level, draw + 1u), rc_path_draw(t, number, path, level, draw + 2u));
      if (!(lamp.irradiance > 0.0f) || rc_lamp_hidden(scene, from, lamp)) continue;
      float factor = lamp.irradiance, more[1 + RC_FURTHER];
      const float4 back = -rc_way_of(&paths->rays, k);
      rc_more_factors(t, surface, side, normal, lamp.direction, back, factor, more);
      if (side == 0u) factor *= rc_shape_factor(t->lobes, surface, normal, lamp.direction, back);
      float light[RC_SKELETON];
      rc_carry_on(scene, t, surface, side, factor, more, paths->carried[k], light);
      float* gained = paths->gained[k] + (1u + source) * t->tile->skeleton;
      for (uint m = 0; m < t->tile->skeleton; m += RC_WORD)
        vstore16(vload16(0, gained + m) + vload16(0, light + m), 0, gained + m);
#if RC_GLOSSY
      if (side == 0u)
        rc_gain_mirrored(scene, t, surface, normal, lamp.direction, back, lamp.irradiance, 0, paths->carried[k],
                         gained);
#endif
    }
  }
}

/* Sky that a path's ray sees: drawn by the cosine, a ray stands for pi sr of it. */
static inline void rc_gain_sky(const PathTables* t, uint k, Paths16* paths) {
  if (!(paths->rays.dz[k] > 0.0f)) return;
  const uint components = t->tile->components;
  if (components == 0u) return;
  float light[RC_SKY_COMPONENTS];
  rc_sky_light(&t->sky, paths->rays.dx[k], paths->rays.dy[k], paths->rays.dz[k], light);
  for (uint m = 0; m < t->tile->skeleton; m += RC_WORD) {
    float16 sky = 0.0f;
    for (uint c = 0; c < components; ++c)
      sky = fma((float16)(light[c]), vload16(0, t->source_share + (t->tile->sun + c) * t->tile->skeleton + m), sky);
    rc_add16(3.14159265f * sky, vload16(0, paths->carried[k] + m), paths->gained[k] + m);
  }
}

/* Ground around the scene that a path's ray meets: the surface after the last one, and the path's end. It lies as low
 * as the scene does, so that light below a lawn comes from nowhere. */
static inline void rc_gain_ground(const PathTables* t, uint k, Paths16* paths) {
  if (!(paths->rays.z[k] > t->lowest)) return;
  for (uint m = 0; m < t->tile->skeleton; m += RC_WORD)
    rc_add16(vload16(0, t->ground_around + m), vload16(0, paths->carried[k] + m), paths->gained[k] + m);
}

/* From their ends the live paths go on: by one side or the gloss, chosen by chance, in a direction by the cosine about
 * it or by that. From the third surface on a path may end, the likelier the less it can carry. Returns those that go
 * on. */
__attribute__((noinline)) static uint rc_go_on(SceneArrays scene, const PathTables* t, uint live, uint level,
                                               Ends16* ends, Paths16* paths) {
  uint on = 0;
  for (; live; live &= live - 1u) {
    const uint k = rc_lowest(live), surface = ends->surface[k], number = paths->number[k], path = paths->path[k];
    float near = t->scattering[surface].x, gloss = RC_GLOSSY ? t->scattering[surface].z : 0.0f;
    if (rc_is_plate(t->lobes, surface)) { /* what goes straight on has done so already (rc_meets) */
      gloss /= gloss + near * (1.0f - gloss);
      near = 1.0f;
    }
    const float draw = rc_path_draw(t, number, path, level, 0u);
    /* Roundings of a draw do not send a path through what is opaque. */
    const bool mirrored = draw < gloss, through = !mirrored && near < 1.0f && draw - gloss >= near * (1.0f - gloss);
    float chance = mirrored ? gloss : (through ? 1.0f - near : near) * (1.0f - gloss);
    paths->reach[k] *= mirrored ? 1.0f : t->scattering[surface].y;
    if (level > 1u) {
      const float goes_on = fmin(1.0f, paths->reach[k]);
      if (rc_path_draw(t, number, path, level, 1u) >= goes_on) continue;
      chance *= goes_on;
      paths->reach[k] /= goes_on;
    }
    float shaped, more[1 + RC_FURTHER];
    const float4 normal = rc_lane_of(ends->normal, k), came = rc_way_of(&paths->rays, k);
#if RC_GLOSSY
    if (mirrored) {
      const Lobe lobe = rc_gloss_of(t->lobes, surface);
      const float4 turned = rc_way_mirrored(t->lobes, lobe, normal, -came, rc_path_draw(t, number, path, level, 2u),
                                            rc_path_draw(t, number, path, level, 3u), &shaped);
      if (!(shaped > 0.0f)) continue;
      rc_more_factors(t, surface, RC_GLOSS_SIDE, normal, turned, -came, shaped / chance, more);
      shaped *= rc_gloss_factor(t->lobes, lobe, normal, turned, -came);
      rc_carry_on(scene, t, surface, RC_GLOSS_SIDE, shaped / chance, more, paths->carried[k], paths->carried[k]);
      rc_put_ray(&paths->rays, k, rc_lane_of(ends->front, k), turned);
      paths->went[k] = RC_GLOSS_SIDE;
      on |= 1u << k;
      continue;
    }
#endif
    const float4 way = rc_way_on(t->lobes, surface, through, normal, came, rc_path_draw(t, number, path, level, 2u),
                                 rc_path_draw(t, number, path, level, 3u), &shaped);
    rc_more_factors(t, surface, through ? 1u : 0u, normal, way, -came, 1.0f / chance, more);
    rc_carry_on(scene, t, surface, through ? 1u : 0u, shaped / chance, more, paths->carried[k], paths->carried[k]);
    rc_put_ray(&paths->rays, k, rc_lane_of(through ? ends->back : ends->front, k), way);
    paths->went[k] = through ? RC_FAR_SIDE : RC_NEAR_SIDE;
    on |= 1u << k;
  }
  return on;
}

/* Whether a path's ray meets a surface, which is then its end. Through plates it goes straight on, as often as they let
 * light through; passed: whether it did. */
__attribute__((noinline)) static bool rc_meets(SceneArrays scene, const PathTables* t, Paths16* paths, uint k,
                                               uint level, bool* passed) {
  *passed = false;
  for (uint plate = 0;; ++plate) {
    const Hit hit = rc_trace_ray(scene, (float4)(paths->rays.x[k], paths->rays.y[k], paths->rays.z[k], 0.0f),
                                 rc_way_of(&paths->rays, k));
    paths->ends.instance[k] = hit.instance, paths->ends.primitive[k] = hit.primitive;
    if (hit.instance == RC_NONE) return false;
    if (!rc_passes_plate(scene, t, paths, k, level, plate, hit)) return true;
    *passed = true;
  }
}

/* Follows the paths from where their first rays ended, t->levels surfaces after the first at most; then their gains are
 * whole. From the last surface they look for the sky alone. */
static inline void rc_follow(SceneArrays scene, const PathTables* t, Paths16* paths) {
  uint live = paths->live;
  for (uint level = 1; live; ++level) {
    rc_stand(scene, t->lobes, &paths->rays, live, &paths->ends);
    const uint stood = live;
    paths->ends.lit = 0u;
    for (uint left = t->tile->thermal_components > 0u ? live : 0u; left; left &= left - 1u) {
      const uint k = rc_lowest(left);
      /* Of a plate that was so when the ray met it. */
      if (rc_is_plate(t->lobes, paths->ends.surface[k])) continue;
      const float4 back = -rc_way_of(&paths->rays, k);
      rc_gain_heat(scene, t, paths->ends.surface[k], rc_lane_of(paths->ends.normal, k), back, paths->carried[k],
                   paths->gained[k]);
    }
    if (t->tile->sun && t->sun_up) rc_gain_sun(scene, t, live, &paths->ends, paths);
    if (t->tile->lamps > 0u) rc_gain_lamps(scene, t, live, level, &paths->ends, paths);
    live = rc_go_on(scene, t, live, level, &paths->ends, paths);
    if (t->log_paths) rc_log_ends(t, stood, live, level, &paths->ends, paths);
    if (level == t->levels) break;
    for (uint left = live; left; left &= left - 1u) {
      const uint k = rc_lowest(left);
      bool passed;
      const bool meets = rc_meets(scene, t, paths, k, level, &passed);
      if (t->log_paths) rc_log_met(rc_step_of(t, paths, k, level), &paths->ends, k);
      if (meets) continue;
      live &= ~(1u << k);
      if (paths->rays.dz[k] > 0.0f)
        rc_gain_sky(t, k, paths);
      else
        rc_gain_ground(t, k, paths);
    }
  }
  if (!live) return;
  Rays16 rays = paths->rays;
  const uint hidden = rc_hidden_of(scene, &rays, live, RC_NONE, 0u);
  for (; live; live &= live - 1u) {
    const uint k = rc_lowest(live);
    if (t->log_paths) rc_step_of(t, paths, k, t->levels)->decided |= hidden >> k & 1u ? RC_STEP_MET : 0u;
    float let[RC_SKELETON];
    if (hidden >> k & 1u && !(rays.dz[k] > 0.0f && rc_let_by_plates(scene, t, &rays, k, let))) continue;
    for (uint m = 0; RC_PLATES && hidden >> k & 1u && m < t->tile->skeleton; m += RC_WORD)
      vstore16(vload16(0, paths->carried[k] + m) * vload16(0, let + m), 0, paths->carried[k] + m);
    rc_gain_sky(t, k, paths);
  }
}

#endif
