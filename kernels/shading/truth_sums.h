/* What a pixel's samples say of it whatever they are made of: path sums by height, and truth (RC_TRUTH_*). */
#ifndef RAYCUBE_KERNELS_SHADING_TRUTH_SUMS_H
#define RAYCUBE_KERNELS_SHADING_TRUTH_SUMS_H

#include "kernels/geometry/lift.h"
#include "kernels/shading/seen_light.h"

typedef struct TruthSums {
  float16 path[RC_HEIGHTS];
  float16 of[RC_TRUTH_SUMS]; /* RC_TRUTH_* */
} TruthSums;

static inline void rc_clear_truth(TruthSums* truth) {
  for (int h = 0; h < RC_HEIGHTS; ++h) truth->path[h] = 0.0f;
  for (int i = 0; i < RC_TRUTH_SUMS; ++i) truth->of[i] = 0.0f;
}

/* Every sample has a path to the sensor, one that hit nothing too: its weight, split over the height nodes. */
static inline void rc_add_path(const ShadedWord* word, const ShadedSamples* samples, int g, TruthSums* truth) {
#if RC_HEIGHTS == 1
  truth->path[0] += word->weight;
#else
  const uint16 hi = rc_load16(g, samples->height_index);
  const float16 hf = rc_load16(g, samples->height_fraction);
  for (uint h = 0; h < RC_HEIGHTS; ++h)
    truth->path[h] +=
        rc_masked(word->weight * (1.0f - hf), hi == (uint16)(h)) + rc_masked(word->weight * hf, hi + 1u == (uint16)(h));
#endif
}

/* Truth is of the surface itself, not of where its shadow rays start. sensor: where it is, scene frame, m. */
static inline void rc_add_truth(const TracedPixel* traced, const ShadedWord* word, float4 sensor, int g,
                                TruthSums* truth) {
  const float16 px = rc_load16(g, traced->point + RC_PLANE(RC_POINT_X)),
                py = rc_load16(g, traced->point + RC_PLANE(RC_POINT_Y)),
                pz = rc_load16(g, traced->point + RC_PLANE(RC_POINT_Z)), reach = rc_load16(g, traced->lift);
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
static inline void rc_close_truth(const TruthSums* truth, float sample_total, PixelRow* row) {
  for (int h = 0; h < RC_HEIGHTS; ++h) rc_add_sum(row->path, RC_HEIGHTS, h, rc_lane_sum(truth->path[h]) / sample_total);
  for (int i = 0; i < RC_TRUTH_SUMS; ++i)
    rc_add_sum(row->truth, RC_TRUTH_SUMS, i, rc_lane_sum(truth->of[i]) / sample_total);
}

#endif
