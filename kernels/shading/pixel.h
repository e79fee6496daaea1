/* One pixel as shading sees it: what tracing left of its samples, and the row that becomes of them
 * (kernels/shared/tile_layout.h). */
#ifndef RAYCUBE_KERNELS_SHADING_PIXEL_H
#define RAYCUBE_KERNELS_SHADING_PIXEL_H

#include "kernels/geometry/lanes.h"
#include "kernels/shared/tile_layout.h"

typedef struct TracedPixel {
  global const uint* hits;     /* [near words][RC_HIT_PLANES][16] */
  global const float* point;   /* [words][RC_POINT_PLANES][16] */
  global const float* lift;    /* [slots] */
  global const ushort* sun;    /* [words] */
  global const float* met_sky; /* [words][sky_planes][16] */
  global const float* weight;  /* [near slots], the chunk's */
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
  /* [word][light][16]: of the direct sun, then of each component and lamp; all carry the sample's weight */
  float value[RC_MOST_LIGHTS * RC_MOST_SLOTS];
  float height_fraction[RC_MOST_SLOTS];
  uint height_index[RC_MOST_SLOTS];
  uint surface[RC_MOST_SLOTS]; /* with its side; RC_NONE: nothing was hit, or it has been summed */
#if RC_SHAPED
  float albedo[RC_MOST_SLOTS]; /* of an even light, what the slot's lobe sends to the viewer; Lambert's: 1 */
#endif
} RC_LINE ShadedSamples;

/* Where the value of a light lies for a slot and for a word of them. */
static inline uint rc_value_slot(const TileShape* tile, uint light, uint slot) {
  return (slot / RC_WORD * rc_lights(tile) + light) * RC_WORD + slot % RC_WORD;
}
static inline uint rc_value_word(const TileShape* tile, uint light, uint word) {
  return word * rc_lights(tile) + light;
}

/* Of word g, the word of the same samples' near sides. */
static inline uint rc_near_word(const TileShape* tile, uint g) {
  return RC_MOST_SIDES > 1 ? g % rc_near_words(tile) : g;
}

/* Row and path and truth sums of an item, empty when it is fresh; its count so far. */
static inline PixelRow rc_open_row(const TileShape* tile, uint fresh, uint count, uint capacity, global ulong* keys,
                                   global float* sums, global float* path, global float* truth) {
  const PixelRow row = {keys, sums, path, truth, fresh ? 0u : count, capacity};
  if (fresh) {
    for (uint i = 0; i < tile->heights * RC_CARRIED(tile->chunked); ++i) path[i] = 0.0f;
    for (uint i = 0; i < RC_TRUTH_SUMS * RC_CARRIED(tile->chunked); ++i) truth[i] = 0.0f;
  }
  return row;
}

#endif
