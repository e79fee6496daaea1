/* Points of a pixel or a group whose light is asked for: gathered, turned towards a direction, and what is hidden from
 * them filed. rc_shadow_points tells which are. */
#ifndef RAYCUBE_KERNELS_LIGHT_LIGHT_POINTS_H
#define RAYCUBE_KERNELS_LIGHT_LIGHT_POINTS_H

#include "kernels/geometry/shadow_points.h"
#include "kernels/geometry/trace_args.h"
#include "kernels/light/spread.h"

/* Points and normals of word `word` (16 samples) of pixels side by side. */
static inline global const float* rc_surface_word(global const float* surface, uint word) {
  return surface + RC_SURFACE_AT(word / RC_WORDS) + word % RC_WORDS * RC_WORD;
}

/* Cosines between a direction and the normals of a word of points. */
static inline float16 rc_cosines(float4 direction, global const float* at) {
  return rc_project_row(direction, rc_load16(0, at + RC_PLANE(RC_NORMAL_X)), rc_load16(0, at + RC_PLANE(RC_NORMAL_Y)),
                        rc_load16(0, at + RC_PLANE(RC_NORMAL_Z)));
}

/* The samples of one part of a pixel side by side: where they came from, their normals, and what is hidden from
 * them. */
typedef struct SkyPart {
  float nx[RC_PADDED_SAMPLES], ny[RC_PADDED_SAMPLES], nz[RC_PADDED_SAMPLES];
  float hidden[RC_PLANE(RC_SKY_PLANES)]; /* by component */
  ushort slot[RC_PADDED_SAMPLES];
  uint count;
} RC_LINE SkyPart;

/* All points of `pixels` pixels side by side, for the sun. */
static inline void rc_gather_points(global const float* surface, uint pixels, Points* points) {
  points->words = pixels * RC_WORDS;
  for (uint word = 0; word < points->words; ++word) {
    global const float* at = rc_surface_word(surface, word);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_X)), word, points->x);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Y)), word, points->y);
    rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Z)), word, points->z);
  }
}

/* The slots of part `part` of `share` of a pixel, for the sky; nothing is hidden from them yet. Points left over in the
 * last word lie on the first and face nothing. */
static inline void rc_gather_part(global const float* surface, uint seed, uint number, uint first_sample, uint part,
                                  uint share, Points* points, SkyPart* held) {
  uint n = 0;
  for (uint slot = 0; slot < RC_PADDED_SAMPLES; ++slot) {
    if (rc_sky_part(seed, number, first_sample + RC_SAMPLE_OF(slot), share) != part) continue;
    points->x[n] = surface[RC_PLANE(RC_POINT_X) + slot];
    points->y[n] = surface[RC_PLANE(RC_POINT_Y) + slot];
    points->z[n] = surface[RC_PLANE(RC_POINT_Z) + slot];
    held->nx[n] = surface[RC_PLANE(RC_NORMAL_X) + slot];
    held->ny[n] = surface[RC_PLANE(RC_NORMAL_Y) + slot];
    held->nz[n] = surface[RC_PLANE(RC_NORMAL_Z) + slot];
    held->slot[n++] = (ushort)slot;
  }
  held->count = n;
  points->words = (n + RC_WORD - 1u) / RC_WORD;
  for (; n < points->words * RC_WORD; ++n) {
    points->x[n] = points->x[0];
    points->y[n] = points->y[0];
    points->z[n] = points->z[0];
    held->nx[n] = held->ny[n] = held->nz[n] = 0.0f;
  }
  for (uint row = 0; row < RC_SKY_PLANES; ++row)
    for (uint word = 0; word < points->words; ++word) rc_store16((float16)(0.0f), word, held->hidden + RC_PLANE(row));
}

/* Cosines between a direction and the normals of word `word` of a part. */
static inline float16 rc_part_cosines(float4 direction, const SkyPart* held, uint word) {
  return rc_project_row(direction, rc_load16(word, held->nx), rc_load16(word, held->ny), rc_load16(word, held->nz));
}

/* Adds what the direction of these weights (RC_SKY_QUADS float4s) would have sent to the points that do not see it;
 * live: those that do. */
static inline void rc_hide_direction(const Points* points, float4 direction, global const float4* weights, uint share,
                                     SkyPart* held) {
  for (uint word = 0; word < points->words; ++word) {
    const float16 facing = rc_part_cosines(direction, held, word);
    const uint dark = rc_mask16(facing > 0.0f) & ~points->live[word];
    if (!dark) continue;
    const float16 cosine = select((float16)(0.0f), facing, rc_lanes(dark)) * (float)share;
    for (uint quad = 0; quad < RC_SKY_QUADS; ++quad) {
      const float4 weight = weights[quad];
      float* to = held->hidden + RC_PLANE(4 * quad);
      rc_store16(fma((float16)(weight.x), cosine, rc_load16(word, to)), word, to);
      rc_store16(fma((float16)(weight.y), cosine, rc_load16(word, to + RC_PLANE(1))), word, to + RC_PLANE(1));
      rc_store16(fma((float16)(weight.z), cosine, rc_load16(word, to + RC_PLANE(2))), word, to + RC_PLANE(2));
      rc_store16(fma((float16)(weight.w), cosine, rc_load16(word, to + RC_PLANE(3))), word, to + RC_PLANE(3));
    }
  }
}

#if RC_SHAPED
/* Of a direction that is open, what other shapes than Lambert's do not turn to the viewer is missing, or more than
 * nothing is there: it joins what is hidden. surface: the pixel's planes. */
static inline void rc_turn_direction(const Points* points, global const float* surface, float4 direction,
                                     global const float4* weights, uint share, SkyPart* held) {
  for (uint n = 0; n < held->count; ++n) {
    const float cosine = fma(direction.x, held->nx[n], fma(direction.y, held->ny[n], direction.z * held->nz[n]));
    if (!(cosine > 0.0f) || !(points->live[n / RC_WORD] >> n % RC_WORD & 1u)) continue;
    const float missing = cosine * (float)share * (1.0f - rc_spread(surface + held->slot[n], direction));
    for (uint row = 0; row < RC_SKY_PLANES; ++row)
      held->hidden[RC_PLANE(row) + n] =
          fma(((global const float*)weights)[row], missing, held->hidden[RC_PLANE(row) + n]);
  }
}
#endif

/* What is hidden from the samples of a part, to their slots of the pixel. */
static inline void rc_write_part(const SkyPart* held, global float* blocked) {
  for (uint row = 0; row < RC_SKY_PLANES; ++row)
    for (uint n = 0; n < held->count; ++n) blocked[RC_PLANE(row) + held->slot[n]] = held->hidden[RC_PLANE(row) + n];
}

#endif
