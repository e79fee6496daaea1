/* How much of a beam's light, spread over its sub-rays, reaches the end from a distance along the owner's middle ray.
 * */
#ifndef RAYCUBE_KERNELS_LIDAR_BEAM_H
#define RAYCUBE_KERNELS_LIDAR_BEAM_H

#include "kernels/geometry/surface_point.h"
#include "kernels/lidar/overlap.h"

/* A table: sums over the sub-rays at distances that rise geometrically, the last once more, log of the first distance,
 * posts per unit of log distance, number of the last post; see layout.h. */

/* Middle ray and the other end. */
typedef struct Beam {
  float4 start, way, apart; /* m; unit; start - end */
  float stretch;            /* length of the record's direction */
  float squared, along;     /* of apart, and along the way */
  float beside;             /* square of what lies across the way */
} Beam;

static inline Beam rc_beam(const LidarTables* t) {
  global const float4* shot = t->shot;
  Beam beam;
  const float4 axis = (float4)(shot[RC_SHOT_AXIS].xyz, 0.0f), from_start = (float4)(shot[RC_SHOT_FROM_START].xyz, 0.0f),
               from_end = (float4)(shot[RC_SHOT_FROM_END].xyz, 0.0f);
  beam.stretch = length(axis);
  beam.way = axis / beam.stretch;
  beam.start = (float4)(shot[RC_SHOT_REFERENCE].xyz, 0.0f) - from_start;
  beam.apart = shot[RC_SHOT_AXIS].w == 1.0f ? (float4)(0.0f) : from_end - from_start;
  beam.squared = dot(beam.apart, beam.apart);
  beam.along = dot(beam.apart, beam.way);
  const float4 across = beam.apart - beam.along * beam.way;
  beam.beside = dot(across, across);
  return beam;
}

/* Distance from the start at which the whole way, to the ray and on to the end, has a length: s + |P(s) - end| = whole.
 * */
static inline float16 rc_beam_distance(const Beam* beam, float16 whole) {
  const float16 more = 2.0f * (whole + beam->along);
  return select((float16)(0.0f), fma(whole, whole, (float16)(-beam->squared)) / more,
                (whole * whole > beam->squared) & (more > 0.0f));
}

static inline float16 rc_dot_axis(Vector16 v, float4 axis) {
  return fma((float16)(axis.x), v.x, fma((float16)(axis.y), v.y, axis.z * v.z));
}

/* What 16 rays (a, b) bring to the end from distance s along their owner's axis, times the square of the middle ray's
 * distance to the end; to pixel `pixel`. transmitter: cos(psi) eta / R^2; receiver: cos^4(psi) F / cos. */
static inline float16 rc_beam_rays(const LidarTables* t, const Beam* beam, float s, float16 a, float16 b,
                                   Vector16 leaves, float pixel) {
  global const float4* shot = t->shot;
  const float4 axis = shot[RC_SHOT_END_AXIS], middle = beam->apart + s * beam->way, whole = beam->way * beam->stretch,
               du = shot[RC_SHOT_DU], dv = shot[RC_SHOT_DV];
  const float norm = dot(middle, middle);
  const Vector16 d = {fma(a, (float16)(du.x), fma(b, (float16)(dv.x), (float16)(whole.x))),
                      fma(a, (float16)(du.y), fma(b, (float16)(dv.y), (float16)(whole.y))),
                      fma(a, (float16)(du.z), fma(b, (float16)(dv.z), (float16)(whole.z)))};
  const float16 unit = rsqrt(d.x * d.x + d.y * d.y + d.z * d.z), far = s * unit;
  const Vector16 v = {fma(far, d.x, leaves.x + beam->apart.x), fma(far, d.y, leaves.y + beam->apart.y),
                      fma(far, d.z, leaves.z + beam->apart.z)};
  const float16 square = fmax(rc_dot16(v, v), 1e-30f), deep = rc_dot_axis(v, axis), cosine = deep * rsqrt(square);
  const int16 ahead = deep > 0.0f;
  const Vector16 beside = {fma(-deep, (float16)(axis.x), v.x), fma(-deep, (float16)(axis.y), v.y),
                           fma(-deep, (float16)(axis.z), v.z)};
  const float16 aside = rc_dot16(beside, beside);
  if (RC_HAS(t, RECEIVER)) {
    const float16 off = rc_dot_axis(d, shot[RC_SHOT_START_AXIS]) * unit, spread = deep * shot[RC_SHOT_END_U].w;
    float16 fluence;
    if (RC_HAS(t, GAUSSIAN)) {
      const float16 spot = fmax(fma(spread, spread, (float16)(axis.w * axis.w)), 1e-30f);
      fluence = 0.636619772f / spot * exp(-2.0f * aside / spot);
    } else {
      const float16 radius = spread + axis.w;
      fluence = select((float16)(0.0f), 0.318309886f / fmax(radius * radius, 1e-30f), aside <= radius * radius);
    }
    return select((float16)(0.0f), off * off * off * off * fluence / fmax(cosine, 1e-6f) * norm, ahead);
  }
  int16 seen = ahead;
  float16 share = cosine * norm / square;
  if (RC_HAS(t, PIXELS)) {
    const float columns = (float)t->columns, rows = (float)t->rows;
    const float16 step = 1.0f / (fmax(deep, 1e-30f) * t->settings[RC_SET_PITCH]);
    const float16 column = floor(fma(rc_dot_axis(v, shot[RC_SHOT_END_U]), step, (float16)(0.5f * columns)));
    const float16 row = floor(fma(rc_dot_axis(v, shot[RC_SHOT_END_V]), step, (float16)(0.5f * rows)));
    seen &= (column >= 0.0f) & (column < columns) & (fma(row, (float16)(columns), column) == pixel);
  } else if (RC_HAS(t, OVERLAP)) {
    share *= rc_vignetting(t->settings, fmax(deep, 1e-20f), sqrt(aside));
  }
  return select((float16)(0.0f), share, seen);
}

/* Word of 16 sub-rays, in either form of the table; see lidar_shots. INFINITY: none. */
static inline void rc_beam_word(const LidarTables* t, uint word, float16* a, float16* b) {
  if (RC_HAS(t, SINGLE)) {
    *a = rc_load16(2u * word, t->samples);
    *b = rc_load16(2u * word + 1u, t->samples);
    return;
  }
  const uint slots = t->slots, words = slots / RC_WORD, bounds = RC_PADDED(words);
  global const float* at = t->samples + (size_t)(word / words) * (2u * slots + 4u * bounds) + word % words * 16u;
  *a = rc_load16(0, at);
  *b = rc_load16(0, at + slots);
}

/* Sum over all rays at one distance. */
static inline float rc_beam_sum(const LidarTables* t, const Beam* beam, float s, float pixel) {
  if (!RC_HAS(t, RECEIVER) && !RC_HAS(t, PIXELS)) {
    /* All of the beam well inside the stop, or no stop: the middle ray speaks for all. */
    const float4 axis = (float4)(t->shot[RC_SHOT_END_AXIS].xyz, 0.0f), v = beam->apart + s * beam->way;
    const float deep = dot(v, axis), square = dot(v, v);
    if (!(deep > 0.0f)) return 0.0f;
    const float4 beside = v - deep * axis;
    const float reach = 0.75f * t->settings[RC_SET_SUPPORT] * s * length(t->shot[RC_SHOT_DU].xyz) +
                        (RC_HAS(t, EXITS) ? 2.5f * length(t->shot[RC_SHOT_EXIT_U].xyz) : 0.0f);
    const float blur = fabs(1.0f / deep - t->settings[RC_SET_FOCUS]) * t->settings[RC_SET_PUPIL];
    if (!RC_HAS(t, OVERLAP) || (length(beside.xyz) + reach) / deep + blur < t->settings[RC_SET_HALF_FOV])
      return deep * rsqrt(square) * (float)t->rays;
  }
  float16 sum = 0.0f;
  const uint padded_rays = rc_padded_rays(t);
  for (uint word = 0; word < padded_rays / RC_WORD; ++word) {
    float16 a, b;
    rc_beam_word(t, word, &a, &b);
    const int16 exists = a < INFINITY;
    Vector16 leaves = {0.0f, 0.0f, 0.0f};
    if (RC_HAS(t, EXITS)) {
      const float4 eu = t->shot[RC_SHOT_EXIT_U], ev = t->shot[RC_SHOT_EXIT_V];
      const float16 ea = rc_load16(word, t->exits), eb = rc_load16(word, t->exits + padded_rays);
      leaves.x = fma(ea, (float16)(eu.x), eb * ev.x);
      leaves.y = fma(ea, (float16)(eu.y), eb * ev.y);
      leaves.z = fma(ea, (float16)(eu.z), eb * ev.z);
    }
    a = select((float16)(0.0f), a, exists);
    b = select((float16)(0.0f), b, exists);
    sum += select((float16)(0.0f), rc_beam_rays(t, beam, s, a, b, leaves, pixel), exists);
  }
  return rc_lane_sum(sum);
}

#endif
