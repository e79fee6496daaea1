/* All points of a group's pixels side by side, for the sun that they share. */
#ifndef RAYCUBE_KERNELS_LIGHT_SUN_POINTS_H
#define RAYCUBE_KERNELS_LIGHT_SUN_POINTS_H

#include "kernels/geometry/shadow_points.h"
#include "kernels/geometry/skyline.h"
#include "kernels/geometry/trace_args.h"

/* Points and normals of word `word` (16 samples) of pixels side by side. */
static inline global const float* rc_surface_word(global const float* surface, uint word) {
  return surface + RC_SURFACE_AT(word / RC_WORDS) + word % RC_WORDS * RC_WORD;
}

/* Cosines between a direction and the normals of a word of points. */
static inline float16 rc_cosines(float4 direction, global const float* at) {
  return rc_project_row(direction, rc_load16(0, at + RC_PLANE(RC_NORMAL_X)), rc_load16(0, at + RC_PLANE(RC_NORMAL_Y)),
                        rc_load16(0, at + RC_PLANE(RC_NORMAL_Z)));
}

static inline void rc_gather_points(global const float* surface, uint pixels, Points* points) {
  points->words = pixels * RC_WORDS;
  for (uint word = 0; word < points->words; ++word) {
    global const float* at = rc_surface_word(surface, word);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_X)), word, points->x);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Y)), word, points->y);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Z)), word, points->z);
  }
}

/* Finds the live points that see the direction past all of the ground. hits: of the points' pixels. */
static inline void rc_find_clear(SceneArrays scene, const Skyline* skyline, global const uint* hits, float4 direction,
                                 Points* points) {
  points->ground = skyline->instance;
  if (skyline->instance == RC_NONE) return;
  for (uint word = 0; word < points->words; ++word) {
    global const uint* at = hits + RC_HITS_AT(word / RC_WORDS) + word % RC_WORDS % RC_NEAR_WORDS * RC_WORD;
    uint clear = 0;
    for (uint left = points->live[word]; left; left &= left - 1u) {
      const uint bit = rc_lowest(left), k = word * 16u + bit;
      const float4 point = (float4)(points->x[k], points->y[k], points->z[k], 0.0f);
      if (rc_above_skyline(scene, skyline, at[bit], point, direction)) clear |= 1u << bit;
    }
    points->clear[word] = clear;
  }
}

#endif
