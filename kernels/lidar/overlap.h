/* Share of the pupil that a point's light passes to a circular field stop (LIDAR specification, 4.3), in float. */
#ifndef RAYCUBE_KERNELS_LIDAR_OVERLAP_H
#define RAYCUBE_KERNELS_LIDAR_OVERLAP_H

#include "kernels/lidar/context.h"

/* x - sin x cos x for 0 <= x <= pi; series below 0.35, where the difference would cancel (next term 2e-8 of the sum). */
static inline float rc_segment(float x) {
  const float y = 2.0f * x, z = y * y;
  const float series = y * z * (1.0f / 12.0f - z * (1.0f / 240.0f - z * (1.0f / 10080.0f - z * (1.0f / 725760.0f))));
  return x < 0.35f ? series : fma(-0.5f, sin(y), x);
}

/* Share of a unit circle that lies within a circle of radius `field`, centres `apart`; all >= 0, finite. The half angles come by
 * atan2 of the common chord, never by acos of a number near 1, and every radicand is a product clamped at 0. */
static inline float rc_covered(float field, float apart) {
  if (apart >= field + 1.0f) return 0.0f;
  if (apart <= field - 1.0f) return 1.0f;
  if (apart <= 1.0f - field) return field * field;
  const float radicand = fmax((field + 1.0f - apart) * (apart + (field - 1.0f)) * (apart - (field - 1.0f)) * (apart + field + 1.0f), 0.0f);
  const float half_chord = 0.5f * sqrt(radicand), square = (field - 1.0f) * (field + 1.0f);  /* times apart */
  const float to_field = 0.5f * fma(apart, apart, square), to_unit = 0.5f * fma(apart, apart, -square);
  const float area = fma(field * field, rc_segment(atan2(half_chord, to_field)), rc_segment(atan2(half_chord, to_unit)));
  return clamp(area * 0.318309886f, 0.0f, 1.0f);
}

/* A point `range` in front of the pupil along its axis and `offset` off it; m, range > 0. */
static inline float rc_vignetting(global const float* settings, float range, float offset) {
  const float blur = fabs(1.0f / range - settings[RC_SET_FOCUS]), angle = offset / range;
  const float field = settings[RC_SET_HALF_FOV], outer = settings[RC_SET_PUPIL] * blur, inner = settings[RC_SET_OBSCURATION] * blur;
  if (!(outer > 1e-12f)) return angle < field ? 1.0f : 0.0f;
  if (angle + outer <= field) return 1.0f;
  float share = rc_covered(field / outer, angle / outer);
  if (inner > 1e-12f) {
    const float hidden = (inner / outer) * (inner / outer);
    share = (share - hidden * rc_covered(field / inner, angle / inner)) / (1.0f - hidden);
  }
  return clamp(share, 0.0f, 1.0f);
}

#endif
