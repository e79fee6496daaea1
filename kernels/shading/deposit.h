/* Sums of a surface's samples into a pixel's row, under the keys of its materials. */
#ifndef RAYCUBE_KERNELS_SHADING_DEPOSIT_H
#define RAYCUBE_KERNELS_SHADING_DEPOSIT_H

#include "kernels/atmosphere/nodes.h"
#include "kernels/shading/pixel.h"
#include "kernels/shading/sums.h"
#include "kernels/shared/product_key.h"

/* Sums over the samples of one surface. */
typedef struct SurfaceSums {
  float value[RC_LIT * RC_HEIGHTS + 1]; /* by source and height node; then coverage */
  float cover[RC_HEIGHTS];              /* coverage by height node, where emission asks for it */
} SurfaceSums;

/* Index of key in the row, appended when new; capacity when the row is full. */
static inline uint rc_find_key(PixelRow* row, ulong key) {
  for (uint k = 0; k < row->count; ++k)
    if (row->keys[k] == key) return k;
  if (row->count == row->capacity) return row->capacity;
  row->keys[row->count] = key;
  for (uint i = 0; i < RC_SUMS_OF_KEY(1); ++i) row->sums[RC_SUMS_OF_KEY(row->count) + i] = 0.0f;
  return row->count++;
}

/* The sums of one side of a surface's samples, times its material fractions, into the row: near light under each
 * material's reflectance, far light under its transmittance. What covers the pixel is told of the near side. Returns
 * false when the row is full.
 * nodes: where each material's temperature lies among the temperature nodes, read only when there are any. */
static inline bool rc_deposit(PixelRow* row, global const Surface* surface, uint side, const SurfaceSums* from,
                              global const float4* nodes) {
  for (int c = 0; c < 4; ++c) {
    const float fraction = surface->fraction[c];
    const uint material = surface->material[c];
    if (material == 0u || fraction == 0.0f) continue;
    const uint k = rc_find_key(row, rc_key_of(rc_curve_id(rc_curve_of_side(side), material - 1u, RC_MATERIALS)));
    if (k == row->capacity) return false;
    global float* sums = row->sums + RC_SUMS_OF_KEY(k);
    for (int i = 0; i < RC_LIT * RC_HEIGHTS; ++i) rc_add_sum(sums, RC_ACCUMULATORS, i, fraction * from->value[i]);
#if RC_TEMPERATURES > 0
    int node;
    float share;
    rc_node_weights(((global const float*)nodes)[c], 0.0f, 1.0f, RC_TEMPERATURES, &node, &share);
    for (int h = 0; h < RC_HEIGHTS; ++h) {
      const int at = (RC_LIT + node) * RC_HEIGHTS + h;
      rc_add_sum(sums, RC_ACCUMULATORS, at, fraction * ((1.0f - share) * from->cover[h]));
      if (share > 0.0f) rc_add_sum(sums, RC_ACCUMULATORS, at + RC_HEIGHTS, fraction * (share * from->cover[h]));
    }
#endif
    if (side == 0u) rc_add_sum(sums, RC_ACCUMULATORS, RC_ACCUMULATORS - 1, fraction * from->value[RC_LIT * RC_HEIGHTS]);
  }
  return true;
}

#endif
