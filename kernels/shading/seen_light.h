/* Of the light that an open sky would send, what reaches the samples: the sun where it is seen, the sky as its rays
 * met it, lamps, each times the sample's weight. 16 samples at a time. */
#ifndef RAYCUBE_KERNELS_SHADING_SEEN_LIGHT_H
#define RAYCUBE_KERNELS_SHADING_SEEN_LIGHT_H

#include "kernels/light/spread.h"
#include "kernels/shading/pixel.h"
#include "kernels/shading/sums.h"

/* 16 samples side by side. */
typedef struct ShadedWord {
  int16 hit, lit; /* met something; that sees the sun */
  float16 weight;
  float16 nx, ny, nz;
  float16 cosine; /* between normal and sun */
} ShadedWord;

static inline ShadedWord rc_shaded_word(const TileShape* tile, const TracedPixel* traced, const ShadedSamples* samples,
                                        float4 sun_direction, uint g) {
  const uint16 lane = (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  global const float* point = traced->point + g * RC_SURFACE_WORD;
  ShadedWord word;
  word.hit = rc_load16(g, samples->surface) != (uint16)(RC_NONE);
  word.lit = word.hit & (((((uint16)((uint)traced->sun[g])) >> lane) & 1u) != 0u);
  word.weight = rc_load16(rc_near_word(tile, g), traced->weight);
  word.nx = rc_load16(0, point + RC_PLANE(RC_NORMAL_X));
  word.ny = rc_load16(0, point + RC_PLANE(RC_NORMAL_Y));
  word.nz = rc_load16(0, point + RC_PLANE(RC_NORMAL_Z));
  word.cosine =
      fma(word.nx, (float16)(sun_direction.x), fma(word.ny, (float16)(sun_direction.y), word.nz * sun_direction.z));
  return word;
}

static inline void rc_weigh_seen_light(const TileShape* tile, const TracedPixel* traced, global const Lobe* lobes,
                                       const ShadedWord* word, float4 sun_direction, uint g, ShadedSamples* samples) {
  float* value = samples->value + rc_value_word(tile, 0u, g) * RC_WORD;
  if (tile->sun) {
    float16 sent = word->weight * fmax(word->cosine, (float16)(0.0f));
#if RC_SHAPED
    sent *= rc_spread16(lobes, traced->point + g * RC_SURFACE_WORD, sun_direction, rc_mask16(word->lit));
#endif
    rc_store16(rc_masked(sent, word->lit), 0, value);
  }
  for (uint m = 0; m < tile->components + tile->lamps; ++m) {
    const uint light = tile->sun + m;
    const float16 e = rc_load16(light, value) + rc_load16(g * tile->sky_planes + m, traced->met_sky);
    rc_store16(rc_masked(word->weight * e, word->hit), light, value);
  }
}

#endif
