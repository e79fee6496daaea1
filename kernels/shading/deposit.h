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
#if RC_LOBE_ALBEDO
  float sent_back[RC_HEIGHTS]; /* the same times the lobe's albedo towards the viewer */
#endif
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

#if RC_TEMPERATURES > 0
/* Adds a part of a surface's coverage, [height], to a key's sums of emission. at: where the material's temperature lies
 * among the nodes. */
static inline void rc_deposit_emission(global float* sums, float at, float fraction, const float* cover) {
  int node;
  float share;
  rc_node_weights(at, 0.0f, 1.0f, RC_TEMPERATURES, &node, &share);
  for (int h = 0; h < RC_HEIGHTS; ++h) {
    const int to = (RC_LIT + node) * RC_HEIGHTS + h;
    rc_add_sum(sums, RC_ACCUMULATORS, to, fraction * ((1.0f - share) * cover[h]));
    if (share > 0.0f) rc_add_sum(sums, RC_ACCUMULATORS, to + RC_HEIGHTS, fraction * (share * cover[h]));
  }
}
#endif

#if RC_LOBE_ALBEDO
/* Emission of one side of a material. What a side sends of itself lacks its curve times its lobe's albedo; the near
 * side's own key has 1 less the curve, so that what the albedo is beyond 1 has a key of its own. Returns false when the
 * row is full. */
static inline bool rc_deposit_leaning(PixelRow* row, uint material, uint side, uint key, float at, float fraction,
                                      const SurfaceSums* from) {
  if (side != RC_NEAR_SIDE) {
    rc_deposit_emission(row->sums + RC_SUMS_OF_KEY(key), at, fraction, from->sent_back);
    return true;
  }
  rc_deposit_emission(row->sums + RC_SUMS_OF_KEY(key), at, fraction, from->cover);
  float beyond[RC_HEIGHTS];
  bool any = false;
  for (int h = 0; h < RC_HEIGHTS; ++h) beyond[h] = from->sent_back[h] - from->cover[h], any |= beyond[h] != 0.0f;
  if (!any) return true;
  const uint k = rc_find_key(row, rc_key_of(rc_curve_id(RC_CURVE_LEANING(RC_FURTHER_RECORDS), material, RC_MATERIALS)));
  if (k == row->capacity) return false;
  rc_deposit_emission(row->sums + RC_SUMS_OF_KEY(k), at, fraction, beyond);
  return true;
}
#endif

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
    if (side == 0u) rc_add_sum(sums, RC_ACCUMULATORS, RC_ACCUMULATORS - 1, fraction * from->value[RC_LIT * RC_HEIGHTS]);
#if RC_LOBE_ALBEDO
    if (!rc_deposit_leaning(row, material - 1u, side, k, ((global const float*)nodes)[c], fraction, from)) return false;
#elif RC_TEMPERATURES > 0
    rc_deposit_emission(sums, ((global const float*)nodes)[c], fraction, from->cover);
#endif
  }
  return true;
}

#endif
