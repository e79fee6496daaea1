/* Samples summed surface by surface, in the order of each surface's first sample. */
#ifndef RAYCUBE_KERNELS_SHADING_SURFACES_H
#define RAYCUBE_KERNELS_SHADING_SURFACES_H

#include "kernels/geometry/scene_arrays.h"
#include "kernels/shading/deposit.h"

/* Sums over the samples of surface `id` (a side of it), the first of which lies in word `first`, and takes them off the
 * list. */
static inline void rc_sum_surface(const TracedPixel* traced, uint id, int first, float sample_total,
                                  ShadedSamples* samples, SurfaceSums* out) {
  float16 sum[RC_LIT * RC_HEIGHTS + 1];
  for (int i = 0; i <= RC_LIT * RC_HEIGHTS; ++i) sum[i] = 0.0f;
#if RC_TEMPERATURES > 0 && RC_HEIGHTS > 1
  float16 covered[RC_HEIGHTS];
  for (int h = 0; h < RC_HEIGHTS; ++h) covered[h] = 0.0f;
#endif
#if RC_LOBE_ALBEDO
  float16 sent_back[RC_HEIGHTS];
  for (int h = 0; h < RC_HEIGHTS; ++h) sent_back[h] = 0.0f;
#endif
  for (int g = first; g < RC_WORDS; ++g) {
    const uint16 ids = rc_load16(g, samples->surface);
    const int16 mine = ids == (uint16)(id);
    const float16 weight = rc_load16(rc_near_word(g), traced->weight);
    sum[RC_LIT * RC_HEIGHTS] += rc_masked(weight, mine);
#if RC_LOBE_ALBEDO
    const float16 even = weight * rc_load16(g, samples->albedo);
#endif
#if RC_HEIGHTS == 1
    for (int m = 0; m < RC_LIT; ++m) sum[m] += rc_masked(rc_load16(g, samples->value[m]), mine);
#if RC_LOBE_ALBEDO
    sent_back[0] += rc_masked(even, mine);
#endif
#else
    const uint16 hi = rc_load16(g, samples->height_index);
    const float16 hf = rc_load16(g, samples->height_fraction);
    for (uint h = 0; h < RC_HEIGHTS; ++h) {
      const float16 part =
          rc_masked(1.0f - hf, mine & (hi == (uint16)(h))) + rc_masked(hf, mine & (hi + 1u == (uint16)(h)));
      for (int m = 0; m < RC_LIT; ++m)
        sum[m * RC_HEIGHTS + h] = fma(rc_load16(g, samples->value[m]), part, sum[m * RC_HEIGHTS + h]);
#if RC_TEMPERATURES > 0
      covered[h] = fma(weight, part, covered[h]);
#endif
#if RC_LOBE_ALBEDO
      sent_back[h] = fma(even, part, sent_back[h]);
#endif
    }
#endif
    rc_store16(select(ids, (uint16)(RC_NONE), as_uint16(mine)), g, samples->surface);
  }
  for (int i = 0; i <= RC_LIT * RC_HEIGHTS; ++i) out->value[i] = rc_lane_sum(sum[i]) / sample_total;
#if RC_TEMPERATURES > 0 && RC_HEIGHTS > 1
  for (int h = 0; h < RC_HEIGHTS; ++h) out->cover[h] = rc_lane_sum(covered[h]) / sample_total;
#elif RC_TEMPERATURES > 0
  out->cover[0] = out->value[RC_LIT];
#endif
#if RC_LOBE_ALBEDO
  for (int h = 0; h < RC_HEIGHTS; ++h) out->sent_back[h] = rc_lane_sum(sent_back[h]) / sample_total;
#endif
}

/* All surfaces of the pixel into its row; a row that is full ends as RC_ROW_OVERFLOW. surface_node: [surface]. */
static inline void rc_deposit_surfaces(SceneArrays scene, const TracedPixel* traced, global const float4* surface_node,
                                       float sample_total, ShadedSamples* samples, PixelRow* row) {
  for (int s = 0; s < RC_PADDED_SAMPLES; ++s) {
    const uint id = samples->surface[s];
    if (id == RC_NONE) continue;
    SurfaceSums sums;
    rc_sum_surface(traced, id, s / RC_WORD, sample_total, samples, &sums);
    const uint number = id & RC_SURFACE_MASK;
    if (!rc_deposit(row, rc_surface(scene, number), RC_SIDE_OF(s), &sums, surface_node + number)) {
      row->count = RC_ROW_OVERFLOW;
      break;
    }
  }
}

#endif
