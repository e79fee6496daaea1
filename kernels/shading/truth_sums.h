/* What a pixel's samples say of it whatever they are made of: path sums by height, and truth (RC_TRUTH_*). */
#ifndef RAYCUBE_KERNELS_SHADING_TRUTH_SUMS_H
#define RAYCUBE_KERNELS_SHADING_TRUTH_SUMS_H

#include "kernels/geometry/lift.h"
#include "kernels/shading/seen_light.h"

typedef struct TruthSums {
  float16 of[RC_TRUTH_SUMS]; /* RC_TRUTH_* */
} TruthSums;

static inline void rc_clear_truth(TruthSums* truth) {
  for (int i = 0; i < RC_TRUTH_SUMS; ++i) truth->of[i] = 0.0f;
}

/* Every sample has a path to the sensor, one that hit nothing too: its weight, split over the height nodes, and added
 * to the row's. */
static inline void rc_add_paths(const TileShape* tile, const TracedPixel* traced, const ShadedSamples* samples,
                                float sample_total, PixelRow* row) {
  for (uint h = 0; h < tile->heights; ++h) {
    float16 path = 0.0f;
    for (uint g = 0; g < rc_near_words(tile); ++g) {
      const float16 weight = rc_load16(g, traced->weight);
      if (tile->heights == 1u) {
        path += weight;
        continue;
      }
      const uint16 hi = rc_load16(g, samples->height_index);
      const float16 hf = rc_load16(g, samples->height_fraction);
      path += rc_masked(weight * (1.0f - hf), hi == (uint16)(h)) + rc_masked(weight * hf, hi + 1u == (uint16)(h));
    }
    rc_add_sum(tile, row->path, tile->heights, h, rc_lane_sum(path) / sample_total);
  }
}

/* Truth is of the surface itself, not of where its shadow rays start. sensor: where it is, scene frame, m. */
static inline void rc_add_truth(const TracedPixel* traced, const ShadedWord* word, float4 sensor, uint g,
                                TruthSums* truth) {
  global const float* point = traced->point + g * RC_SURFACE_WORD;
  const float16 px = rc_load16(0, point + RC_PLANE(RC_POINT_X)), py = rc_load16(0, point + RC_PLANE(RC_POINT_Y)),
                pz = rc_load16(0, point + RC_PLANE(RC_POINT_Z)), reach = rc_load16(g, traced->lift);
  const float16 x = rc_step_back(px, word->nx, reach), y = rc_step_back(py, word->ny, reach),
                z = rc_step_back(pz, word->nz, reach);
  const float16 rx = x - sensor.x, ry = y - sensor.y, rz = z - sensor.z;
  const float16 range = sqrt(fma(rx, rx, fma(ry, ry, rz * rz)));
  const float16 w_hit = rc_masked(word->weight, word->hit);
  truth->of[RC_TRUTH_HIT] += w_hit;
  truth->of[RC_TRUTH_SUN] += rc_masked(word->weight, word->lit);
  truth->of[RC_TRUTH_X] += rc_masked(w_hit * x, word->hit);
  truth->of[RC_TRUTH_Y] += rc_masked(w_hit * y, word->hit);
  truth->of[RC_TRUTH_Z] += rc_masked(w_hit * z, word->hit);
  truth->of[RC_TRUTH_RANGE] += rc_masked(w_hit * range, word->hit);
  truth->of[RC_TRUTH_INCIDENCE] += rc_masked(w_hit * word->cosine, word->hit);
  const float16 towards = -fma(word->nx, rx, fma(word->ny, ry, word->nz * rz)) / range;
  truth->of[RC_TRUTH_VIEW] += rc_masked(w_hit * towards, word->hit);
}

/* Adds them to the row's. */
static inline void rc_close_truth(const TileShape* tile, const TruthSums* truth, float sample_total, PixelRow* row) {
  for (uint i = 0; i < RC_TRUTH_SUMS; ++i)
    rc_add_sum(tile, row->truth, RC_TRUTH_SUMS, i, rc_lane_sum(truth->of[i]) / sample_total);
}

#endif
