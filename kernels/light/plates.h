/* Plates along paths of light: what they let through goes straight on, and is no scattering. Compiled in where some
 * material is one (RC_PLATES); to every other ray of a camera a plate is opaque. */
#ifndef RAYCUBE_KERNELS_LIGHT_PLATES_H
#define RAYCUBE_KERNELS_LIGHT_PLATES_H

#include "kernels/geometry/ray_trace.h"
#include "kernels/light/heat.h"
#include "kernels/light/path_matter.h"

#define RC_PLATE_DIMENSION 4096u /* of rc_hash, and one more for each plate: past a path's others */
#define RC_MOST_PLATES 4096u     /* on one ray: more would be an error of rounding */

#if RC_PLATES
/* Puts a ray that met a plate behind it. */
__attribute__((noinline)) static void rc_go_behind(SceneArrays scene, const PathTables* t, Rays16* rays, uint k,
                                                   Hit hit) {
  Ends16 at;
  at.instance[k] = hit.instance, at.primitive[k] = hit.primitive;
  rc_stand(scene, t->lobes, rays, 1u << k, &at);
  rc_put_ray(rays, k, rc_lane_of(at.back, k), rc_way_of(rays, k));
}

/* Normal, to its side, of what a ray met: of plates that send by the angle; else no one asks. */
static inline float4 rc_normal_met(SceneArrays scene, const PathTables* t, const Rays16* rays, uint k, Hit hit) {
#if RC_SHAPED
  if (!t->tile->lobe_albedo) return (float4)(0.0f);
  Ends16 at;
  at.instance[k] = hit.instance, at.primitive[k] = hit.primitive;
  rc_stand(scene, t->lobes, rays, 1u << k, &at);
  return rc_lane_of(at.normal, k);
#else
  return (float4)(0.0f);
#endif
}

/* Multiplies what is carried by a plate's transmittance, and that by `factor`. */
static inline void rc_carry_through(SceneArrays scene, const PathTables* t, uint surface, float factor,
                                    float* carried) {
  float more[1 + RC_FURTHER];
  for (uint number = 0; number < RC_FURTHER; ++number) more[number] = 0.0f;
  rc_carry_on(scene, t, surface, RC_FAR_SIDE, factor, more, carried, carried);
}

/* Whether nothing but plates lies ahead of a ray, whose lane is used up; let: product of what they let through, at the
 * skeleton wavelengths. */
__attribute__((noinline)) static bool rc_behind_plates(SceneArrays scene, const PathTables* t, Rays16* rays, uint k,
                                                       float* let) {
  for (uint m = 0; m < t->tile->skeleton; m += RC_WORD) vstore16((float16)(1.0f), 0, let + m);
  for (uint plate = 0; plate < RC_MOST_PLATES; ++plate) {
    const Hit hit = rc_trace_ray(scene, (float4)(rays->x[k], rays->y[k], rays->z[k], 0.0f), rc_way_of(rays, k));
    if (hit.instance == RC_NONE) return true;
    const uint surface = rc_surface_of(scene, hit.primitive);
    if (!rc_is_plate(t->lobes, surface)) return false;
    rc_carry_through(scene, t, surface, 1.0f, let);
    rc_go_behind(scene, t, rays, k, hit);
  }
  return false;
}
#endif

/* Whether light comes along a ray that something hides, because that is plates alone. */
static inline bool rc_let_by_plates(SceneArrays scene, const PathTables* t, Rays16* rays, uint k, float* let) {
#if RC_PLATES
  return rc_behind_plates(scene, t, rays, k, let);
#else
  return false;
#endif
}

/* Whether a path whose ray met `hit` goes straight on behind it: never where that is no plate. plate: how many of this
 * ray were passed before. */
static inline bool rc_passes_plate(SceneArrays scene, const PathTables* t, Paths16* paths, uint k, uint level,
                                   uint plate, Hit hit) {
#if RC_PLATES
  const uint surface = rc_surface_of(scene, hit.primitive);
  if (!rc_is_plate(t->lobes, surface)) return false;
  const float4 way = rc_way_of(&paths->rays, k);
  if (t->tile->thermal_components > 0u)
    rc_gain_heat(scene, t, surface, rc_normal_met(scene, t, &paths->rays, k, hit), -way, paths->carried[k],
                 paths->gained[k]);
  const float4 law = t->scattering[surface];
  const float on = (1.0f - law.x) * (1.0f - (RC_GLOSSY ? law.z : 0.0f));
  const float draw =
      rc_unit_float(rc_hash(t->seed, paths->number[k], (paths->path[k] << 8) + level, RC_PLATE_DIMENSION + plate));
  const bool lost = plate >= RC_MOST_PLATES;
  if (draw >= on || lost) {
    for (uint m = 0; m < t->tile->skeleton; m += RC_WORD) {
      const float16 stays = vload16(0, paths->carried[k] + m) / (1.0f - on);
      vstore16(lost ? (float16)(0.0f) : stays, 0, paths->carried[k] + m);
    }
    return false;
  }
  rc_carry_through(scene, t, surface, 1.0f / on, paths->carried[k]);
  rc_go_behind(scene, t, &paths->rays, k, hit);
  return true;
#else
  return false;
#endif
}

#endif
