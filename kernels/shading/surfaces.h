/* Samples summed surface by surface, in the order of each surface's first sample. */
#ifndef RAYCUBE_KERNELS_SHADING_SURFACES_H
#define RAYCUBE_KERNELS_SHADING_SURFACES_H

#include "kernels/geometry/scene_arrays.h"
#include "kernels/shading/deposit.h"

/* Words of a pixel's slots in which a surface has samples, and in which lanes. */
typedef struct SurfaceWords {
  ushort word[RC_MOST_SLOTS / RC_WORD], lanes[RC_MOST_SLOTS / RC_WORD];
  uint count;
} SurfaceWords;

/* Those of surface `id` (a side of it), the first of which is word `first`; its samples are taken off the list. */
static inline void rc_find_words(const TileShape* tile, uint id, uint first, ShadedSamples* samples,
                                 SurfaceWords* out) {
  out->count = 0;
  for (uint g = first; g < tile->words; ++g) {
    const uint16 ids = rc_load16(g, samples->surface);
    const int16 mine = ids == (uint16)(id);
    const uint lanes = rc_mask16(mine);
    if (!lanes) continue;
    out->word[out->count] = (ushort)g;
    out->lanes[out->count++] = (ushort)lanes;
    rc_store16(select(ids, (uint16)(RC_NONE), as_uint16(mine)), g, samples->surface);
  }
}

/* How much of each sample of word g belongs to height node h. */
static inline float16 rc_part_of_node(const ShadedSamples* samples, uint g, uint h, int16 mine) {
  const uint16 hi = rc_load16(g, samples->height_index);
  const float16 hf = rc_load16(g, samples->height_fraction);
  return rc_masked(1.0f - hf, mine & (hi == (uint16)(h))) + rc_masked(hf, mine & (hi + 1u == (uint16)(h)));
}

/* Sum of one light over a surface's samples at height node h. */
static inline float rc_sum_light(const TileShape* tile, const ShadedSamples* samples, const SurfaceWords* words,
                                 uint light, uint h) {
  float16 sum = 0.0f;
  for (uint i = 0; i < words->count; ++i) {
    const uint g = words->word[i];
    const int16 mine = rc_bits16(words->lanes[i]);
    const float16 value = rc_load16(rc_value_word(tile, light, g), samples->value);
    if (tile->heights == 1u)
      sum += rc_masked(value, mine);
    else
      sum = fma(value, rc_part_of_node(samples, g, h, mine), sum);
  }
  return rc_lane_sum(sum);
}

/* Sum of the weights of a surface's samples: all of them (all = true, h is not read) or their part at height node h;
 * albedo: times what their lobes send back of an even light. */
static inline float rc_sum_weights(const TileShape* tile, const TracedPixel* traced, const ShadedSamples* samples,
                                   const SurfaceWords* words, bool all, uint h, bool albedo) {
  float16 sum = 0.0f;
  for (uint i = 0; i < words->count; ++i) {
    const uint g = words->word[i];
    const int16 mine = rc_bits16(words->lanes[i]);
    float16 weight = rc_load16(rc_near_word(tile, g), traced->weight);
#if RC_SHAPED
    if (albedo) weight *= rc_load16(g, samples->albedo);
#endif
    if (all || tile->heights == 1u)
      sum += rc_masked(weight, mine);
    else
      sum = fma(weight, rc_part_of_node(samples, g, h, mine), sum);
  }
  return rc_lane_sum(sum);
}

/* Sums over the samples of surface `id` (a side of it), the first of which lies in word `first`, and takes them off the
 * list. */
static inline void rc_sum_surface(const TileShape* tile, const TracedPixel* traced, uint id, uint first,
                                  float sample_total, ShadedSamples* samples, SurfaceSums* out) {
  const uint lights = rc_lights(tile), heights = tile->heights;
  SurfaceWords words;
  rc_find_words(tile, id, first, samples, &words);
  for (uint m = 0; m < lights; ++m)
    for (uint h = 0; h < heights; ++h)
      out->value[m * heights + h] = rc_sum_light(tile, samples, &words, m, h) / sample_total;
  const float covered = rc_sum_weights(tile, traced, samples, &words, true, 0u, false) / sample_total;
  out->value[lights * heights] = covered;
  for (uint h = 0; tile->temperatures > 0u && h < heights; ++h) {
    out->cover[h] =
        heights > 1u ? rc_sum_weights(tile, traced, samples, &words, false, h, false) / sample_total : covered;
#if RC_SHAPED
    if (tile->lobe_albedo)
      out->sent_back[h] = rc_sum_weights(tile, traced, samples, &words, false, h, true) / sample_total;
#endif
  }
}

/* All surfaces of the pixel into its row; a row that is full ends as RC_ROW_OVERFLOW. surface_node: [surface]. */
static inline void rc_deposit_surfaces(SceneArrays scene, const TileShape* tile, const TracedPixel* traced,
                                       global const float4* surface_node, float sample_total, ShadedSamples* samples,
                                       PixelRow* row) {
  for (uint s = 0; s < RC_WORD * tile->words; ++s) {
    const uint id = samples->surface[s];
    if (id == RC_NONE) continue;
    SurfaceSums sums;
    rc_sum_surface(tile, traced, id, s / RC_WORD, sample_total, samples, &sums);
    const uint number = id & RC_SURFACE_MASK;
    if (!rc_deposit(tile, row, rc_surface(scene, number), id >> RC_SIDE_SHIFT, &sums, surface_node + number)) {
      row->count = RC_ROW_OVERFLOW;
      break;
    }
  }
}

#endif
