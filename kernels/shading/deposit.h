/* Sums of a surface's samples into a pixel's row, under the keys of its materials. */
#ifndef RAYCUBE_KERNELS_SHADING_DEPOSIT_H
#define RAYCUBE_KERNELS_SHADING_DEPOSIT_H

#include "kernels/atmosphere/nodes.h"
#include "kernels/shading/pixel.h"
#include "kernels/shading/sums.h"
#include "kernels/shared/product_key.h"

/* Sums over the samples of one surface. */
typedef struct SurfaceSums {
  float value[RC_MAX_CHANNELS + 1]; /* by source and height node; then coverage */
  float cover[RC_MAX_CHANNELS];     /* coverage by height node, where emission asks for it */
#if RC_SHAPED
  float sent_back[RC_MAX_CHANNELS]; /* the same times the lobe's albedo towards the viewer */
#endif
} SurfaceSums;

/* Index of key in the row, appended when new; capacity when the row is full. */
static inline uint rc_find_key(const TileShape* tile, PixelRow* row, ulong key) {
  for (uint k = 0; k < row->count; ++k)
    if (row->keys[k] == key) return k;
  if (row->count == row->capacity) return row->capacity;
  row->keys[row->count] = key;
  global float* sums = row->sums + rc_sums_of_key(tile, row->count);
  for (uint i = 0; i < rc_sums_of_key(tile, 1u); ++i) sums[i] = 0.0f;
  return row->count++;
}

/* Adds a part of a surface's coverage, [height], to a key's sums of emission. at: where the material's temperature lies
 * among the nodes. */
static inline void rc_deposit_emission(const TileShape* tile, global float* sums, float at, float fraction,
                                       const float* cover) {
  const uint heights = tile->heights, count = rc_accumulators(tile);
  int node;
  float share;
  rc_node_weights(at, 0.0f, 1.0f, (int)tile->temperatures, &node, &share);
  for (uint h = 0; h < heights; ++h) {
    const uint to = (rc_lights(tile) + (uint)node) * heights + h;
    rc_add_sum(tile, sums, count, to, fraction * ((1.0f - share) * cover[h]));
    if (share > 0.0f) rc_add_sum(tile, sums, count, to + heights, fraction * (share * cover[h]));
  }
}

#if RC_SHAPED
/* Emission of one side of a material where it goes by the angle. What a side sends of itself lacks its curve times its
 * lobe's albedo; the near side's own key has 1 less the curve, so that what the albedo is beyond 1 has a key of its
 * own. Returns false when the row is full. */
static inline bool rc_deposit_leaning(const TileShape* tile, PixelRow* row, uint material, uint side, uint key,
                                      float at, float fraction, const SurfaceSums* from) {
  global float* sums = row->sums + rc_sums_of_key(tile, key);
  if (side != RC_NEAR_SIDE) {
    rc_deposit_emission(tile, sums, at, fraction, from->sent_back);
    return true;
  }
  rc_deposit_emission(tile, sums, at, fraction, from->cover);
  float beyond[RC_MAX_CHANNELS];
  bool any = false;
  for (uint h = 0; h < tile->heights; ++h) beyond[h] = from->sent_back[h] - from->cover[h], any |= beyond[h] != 0.0f;
  if (!any) return true;
  const uint k =
      rc_find_key(tile, row, rc_key_of(rc_curve_id(RC_CURVE_LEANING(RC_FURTHER_RECORDS), material, tile->materials)));
  if (k == row->capacity) return false;
  rc_deposit_emission(tile, row->sums + rc_sums_of_key(tile, k), at, fraction, beyond);
  return true;
}
#endif

/* The sums of one side of a surface's samples, times its material fractions, into the row: near light under each
 * material's reflectance, far light under its transmittance. What covers the pixel is told of the near side. Returns
 * false when the row is full.
 * nodes: where each material's temperature lies among the temperature nodes, read only when there are any. */
static inline bool rc_deposit(const TileShape* tile, PixelRow* row, global const Surface* surface, uint side,
                              const SurfaceSums* from, global const float4* nodes) {
  const uint count = rc_accumulators(tile), lit = rc_lights(tile) * tile->heights;
  for (uint c = 0; c < 4u; ++c) {
    const float fraction = surface->fraction[c];
    const uint material = surface->material[c];
    if (material == 0u || fraction == 0.0f) continue;
    const uint k =
        rc_find_key(tile, row, rc_key_of(rc_curve_id(rc_curve_of_side(side), material - 1u, tile->materials)));
    if (k == row->capacity) return false;
    global float* sums = row->sums + rc_sums_of_key(tile, k);
    for (uint i = 0; i < lit; ++i) rc_add_sum(tile, sums, count, i, fraction * from->value[i]);
    if (side == RC_NEAR_SIDE) rc_add_sum(tile, sums, count, count - 1u, fraction * from->value[lit]);
    if (tile->temperatures == 0u) continue;
    const float at = ((global const float*)nodes)[c];
#if RC_SHAPED
    if (tile->lobe_albedo) {
      if (!rc_deposit_leaning(tile, row, material - 1u, side, k, at, fraction, from)) return false;
      continue;
    }
#endif
    rc_deposit_emission(tile, sums, at, fraction, from->cover);
  }
  return true;
}

#endif
