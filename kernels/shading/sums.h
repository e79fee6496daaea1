/* Sums over samples: of lanes by one fixed tree, of chunks with their rounding errors. */
#ifndef RAYCUBE_KERNELS_SHADING_SUMS_H
#define RAYCUBE_KERNELS_SHADING_SUMS_H

#include "kernels/geometry/lanes.h"
#include "kernels/shared/tile_layout.h"

static inline float16 rc_masked(float16 v, int16 mask) { return select((float16)(0.0f), v, mask); }

/* Adds x to sum `index` of an array of `count` sums. Where they are carried from chunk to chunk, their errors follow
 * them: Neumaier's compensated addition (ZAMM 54, 1974), exact to about one rounding. */
static inline void rc_add_sum(const TileShape* tile, global float* sums, uint count, uint index, float x) {
  const float s = sums[index], t = s + x;
  if (tile->chunked) sums[index + count] += fabs(s) >= fabs(x) ? (s - t) + x : (x - t) + s;
  sums[index] = t;
}

/* What has been added to it. */
static inline float rc_sum_of(const TileShape* tile, global const float* sums, uint count, uint index) {
  return tile->chunked ? sums[index] + sums[index + count] : sums[index];
}

#endif
