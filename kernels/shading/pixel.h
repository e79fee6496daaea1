/* One pixel as shading sees it: what tracing left of its samples, and the row that becomes of them
 * (kernels/shared/tile_layout.h). */
#ifndef RAYCUBE_KERNELS_SHADING_PIXEL_H
#define RAYCUBE_KERNELS_SHADING_PIXEL_H

#include "kernels/geometry/lanes.h"
#include "kernels/shared/tile_layout.h"

typedef struct TracedPixel {
  global const uint *instance, *primitive; /* [near slots] */
  global const float* point;               /* [RC_POINT_PLANES][padded] */
  global const float* lift;                /* [padded] */
  global const ushort* sun;                /* [words] */
  global const float* met_sky;             /* [RC_SKY_PLANES][padded] */
  global const float* weight;              /* [RC_NEAR_SAMPLES], the chunk's */
} TracedPixel;

typedef struct PixelRow {
  global ulong* keys;
  global float *sums, *path, *truth;
  uint count, capacity;
} PixelRow;

/* A surface's number with one of its sides. */
#define RC_SIDE_SHIFT 27u
#define RC_SURFACE_MASK ((1u << RC_SIDE_SHIFT) - 1u)

/* What is known of each sample before surfaces are told apart. */
typedef struct ShadedSamples {
  float value[RC_LIT][RC_PADDED_SAMPLES]; /* of the direct sun, then of each component; all carry the sample's weight */
  float height_fraction[RC_PADDED_SAMPLES];
  uint height_index[RC_PADDED_SAMPLES];
  uint surface[RC_PADDED_SAMPLES]; /* with its side; RC_NONE: nothing was hit, or it has been summed */
#if RC_LOBE_ALBEDO
  float albedo[RC_PADDED_SAMPLES]; /* of an even light, what the slot's lobe sends to the viewer; Lambert's: 1 */
#endif
} RC_LINE ShadedSamples;

/* Of word g, the word of the same samples' near sides. */
static inline int rc_near_word(int g) { return RC_SIDES > 1 ? g % RC_NEAR_WORDS : g; }

/* Row and path and truth sums of an item, empty when it is fresh; its count so far. */
static inline PixelRow rc_open_row(uint fresh, uint count, uint capacity, global ulong* keys, global float* sums,
                                   global float* path, global float* truth) {
  const PixelRow row = {keys, sums, path, truth, fresh ? 0u : count, capacity};
  if (fresh) {
    for (int i = 0; i < RC_HEIGHTS * RC_CARRIED(RC_CHUNKED); ++i) path[i] = 0.0f;
    for (int i = 0; i < RC_TRUTH_SUMS * RC_CARRIED(RC_CHUNKED); ++i) truth[i] = 0.0f;
  }
  return row;
}

#endif
