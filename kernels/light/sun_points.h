/* All points of a group's pixels side by side, for the sun that they share. */
#ifndef RAYCUBE_KERNELS_LIGHT_SUN_POINTS_H
#define RAYCUBE_KERNELS_LIGHT_SUN_POINTS_H

#include "kernels/geometry/shadow_points.h"
#include "kernels/geometry/skyline.h"
#include "kernels/geometry/trace_args.h"

/* Points and normals of word `word` (16 samples) of the sides that send rays, of pixels side by side. */
static inline global const float* rc_surface_word(const TileShape* tile, global const float* surface, uint word) {
  const uint own_words = rc_own_words(tile), pixel = word / own_words;
  return surface + rc_surface_at(tile, pixel) + (word - pixel * own_words) * RC_SURFACE_WORD;
}

/* Cosines between a direction and the normals of a word of points. */
static inline float16 rc_cosines(float4 direction, global const float* at) {
  return rc_project_row(direction, rc_load16(0, at + RC_PLANE(RC_NORMAL_X)), rc_load16(0, at + RC_PLANE(RC_NORMAL_Y)),
                        rc_load16(0, at + RC_PLANE(RC_NORMAL_Z)));
}

static inline void rc_gather_points(const TileShape* tile, global const float* surface, uint pixels, Points* points) {
  points->words = pixels * rc_own_words(tile);
  points->word_slots = (points->words + 15u) / 16u * 16u;
  for (uint word = 0; word < points->words; ++word) {
    global const float* at = rc_surface_word(tile, surface, word);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_X)), word, points->x);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Y)), word, points->y);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Z)), word, points->z);
  }
}

#define RC_GROUND_CELLS 64.0f /* that are looked at for a group's points; over more of them nothing is known */

/* The ground's instance where all live points see the direction past all of it, else RC_NONE: by the cells of the box
 * around them, in the ground's frame. hits: of the points' pixels. */
static inline uint rc_ground_passed(SceneArrays scene, const TileShape* tile, const Skyline* skyline,
                                    global const uint* hits, float4 direction, const Points* points) {
  if (skyline->instance == RC_NONE) return RC_NONE;
  global const Instance* placed = rc_instance(scene, skyline->instance);
  const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
  const bool same = placed->flags & 1u;
  const float4 d = same ? direction : rc_map_vector(r0, r1, r2, direction);
  if (!(d.z > 0.0f)) return RC_NONE;
  float16 lo_x = INFINITY, hi_x = -INFINITY, lo_y = INFINITY, hi_y = -INFINITY, lo_z = INFINITY;
  for (uint word = 0; word < points->words; ++word) {
    if (!points->live[word]) continue;
    const int16 live = rc_bits16(points->live[word]);
    Vector16 at = {rc_load16(word, points->x), rc_load16(word, points->y), rc_load16(word, points->z)};
    if (!same) at = rc_map_points16(r0, r1, r2, at);
    lo_x = rc_min16(lo_x, select((float16)(INFINITY), at.x, live));
    hi_x = rc_max16(hi_x, select((float16)(-INFINITY), at.x, live));
    lo_y = rc_min16(lo_y, select((float16)(INFINITY), at.y, live));
    hi_y = rc_max16(hi_y, select((float16)(-INFINITY), at.y, live));
    /* Points on the ground need not lie above it. */
    const uint pixel = word / rc_own_words(tile), own = word - pixel * rc_own_words(tile);
    global const uint* left = hits + rc_hits_at(tile, pixel) + own % rc_near_words(tile) * RC_HIT_WORD;
    lo_z = rc_min16(lo_z, select((float16)(INFINITY), at.z, live & (rc_load16(0, left) != skyline->instance)));
  }
  const float x0 = (rc_least16(lo_x) - skyline->x) * skyline->per_cell,
              x1 = (rc_most16(hi_x) - skyline->x) * skyline->per_cell;
  const float y0 = (rc_least16(lo_y) - skyline->y) * skyline->per_cell,
              y1 = (rc_most16(hi_y) - skyline->y) * skyline->per_cell;
  const float lowest = rc_least16(lo_z), steep = d.z * d.z, flat = fma(d.x, d.x, d.y * d.y);
  if (!(x0 >= 0.0f && y0 >= 0.0f && x0 <= x1 && y0 <= y1 && x1 < (float)skyline->columns && y1 < (float)skyline->rows &&
        (x1 - x0 + 1.0f) * (y1 - y0 + 1.0f) <= RC_GROUND_CELLS))
    return RC_NONE;
  for (uint y = (uint)y0; y <= (uint)y1; ++y)
    for (uint x = (uint)x0; x <= (uint)x1; ++x) {
      global const float* cell = skyline->cells + 2u * (y * skyline->columns + x);
      if (!(steep > cell[1] * flat && lowest >= cell[0])) return RC_NONE;
    }
  return skyline->instance;
}

#endif
