/* Share of the pupil that a point's light passes to a circular field stop (LIDAR specification, 4.3), in float. */
#ifndef RAYCUBE_KERNELS_LIDAR_OVERLAP_H
#define RAYCUBE_KERNELS_LIDAR_OVERLAP_H

#include "kernels/lidar/context.h"

/* x - sin x cos x for 0 <= x <= pi; series below 0.35, where the difference would cancel (next term 2e-8 of the sum).
 * */
static inline float16 rc_segment(float16 x) {
  const float16 y = 2.0f * x, z = y * y;
  const float16 series = y * z * (1.0f / 12.0f - z * (1.0f / 240.0f - z * (1.0f / 10080.0f - z * (1.0f / 725760.0f))));
  return select(fma((float16)(-0.5f), sin(y), x), series, x < 0.35f);
}

/* Share of a unit circle that lies within a circle of radius `field`, centres `apart`; all >= 0, finite. The half
 * angles come by atan2 of the common chord, never by acos of a number near 1, and every radicand is a product clamped
 * at 0. */
static inline float16 rc_covered(float16 field, float16 apart) {
  const float16 more = field - 1.0f;
  const float16 radicand =
      fmax((field + 1.0f - apart) * (apart + more) * (apart - more) * (apart + field + 1.0f), 0.0f);
  const float16 half_chord = 0.5f * sqrt(radicand), square = more * (field + 1.0f); /* times apart */
  const float16 to_field = 0.5f * fma(apart, apart, square), to_unit = 0.5f * fma(apart, apart, -square);
  const float16 area =
      fma(field * field, rc_segment(atan2(half_chord, to_field)), rc_segment(atan2(half_chord, to_unit)));
  float16 share = clamp(area * 0.318309886f, 0.0f, 1.0f);
  share = select(share, field * field, apart <= -more);
  share = select(share, (float16)(1.0f), apart <= more);
  return select(share, (float16)(0.0f), apart >= field + 1.0f);
}

/* Points `range` in front of the pupil along its axis and `offset` off it; m, range > 0. */
static inline float16 rc_vignetting(global const float* settings, float16 range, float16 offset) {
  const float16 defocus = fabs(1.0f / range - settings[RC_SET_FOCUS]), angle = offset / range;
  const float field = settings[RC_SET_HALF_FOV];
  const float16 outer = settings[RC_SET_PUPIL] * defocus, inner = settings[RC_SET_OBSCURATION] * defocus;
  const float16 blur = fmax(outer, 1e-12f), hole = fmax(inner, 1e-12f);
  const int16 whole = angle + blur <= field, sharp = outer <= 1e-12f;
  if (!rc_mask16(~(whole | sharp)))
    return select(select((float16)(0.0f), (float16)(1.0f), angle < field), (float16)(1.0f), whole);
  float16 share = rc_covered(field / blur, angle / blur);
  if (settings[RC_SET_OBSCURATION] > 0.0f) {
    const float16 hidden = (inner / blur) * (inner / blur);
    share = clamp((share - hidden * rc_covered(field / hole, angle / hole)) / (1.0f - hidden), 0.0f, 1.0f);
  }
  share = select(share, select((float16)(0.0f), (float16)(1.0f), angle < field), sharp);
  return select(share, (float16)(1.0f), whole);
}

#endif
