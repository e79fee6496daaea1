/* Puts a pulse of some energy at its place in a row of bins. */
#ifndef RAYCUBE_KERNELS_LIDAR_DEPOSIT_H
#define RAYCUBE_KERNELS_LIDAR_DEPOSIT_H

#include "kernels/lidar/context.h"

/* bin + phase (0 <= phase < 1): position of the pulse's centre. */
static inline void rc_deposit(const LidarTables* t, global float* row, float sums[RC_SUM_COUNT][2], int bin, float phase, float energy) {
  const int start = bin + t->first_tap;
  if (start + t->tap_count <= 0) {
    rc_add_float(sums[RC_SUM_EARLY], energy);
  } else if (start >= t->bins) {
    rc_add_float(sums[RC_SUM_LATE], energy);
  } else {
    const float x = phase * (float)t->phases;
    const int q = min((int)x, t->phases - 1);
    const float f = x - (float)q;
    global const float* low = t->taps + q * RC_TAPS_PADDED;
    global float* to = row + (RC_ROW_PAD + start);
    #pragma unroll
    for (int i = 0; i < RC_TAPS_PADDED; i += 16) {
      const float16 a = vload16(0, low + i), b = vload16(0, low + RC_TAPS_PADDED + i);
      rc_store16(fma((float16)(energy), fma((float16)(f), b - a, a), vload16(0, to + i)), 0, to + i);
    }
  }
}

/* The same for lanes of a word, one after the other, into one row. Neighbours mostly fall into the same bins: these are kept in
 * registers until another start comes. */
static inline void rc_deposit_lanes(const LidarTables* t, global float* row, float sums[RC_SUM_COUNT][2], uint lanes, const int* bin,
                                    const float* phase, const float* energy) {
  float16 kept[RC_TAPS_PADDED / 16];
  int start = 0;
  bool any = false;
  for (uint left = lanes; left; left &= left - 1u) {
    const uint k = rc_lowest(left);
    const int here = bin[k] + t->first_tap;
    const float e = energy[k];
    if (here + t->tap_count <= 0) {
      rc_add_float(sums[RC_SUM_EARLY], e);
      continue;
    }
    if (here >= t->bins) {
      rc_add_float(sums[RC_SUM_LATE], e);
      continue;
    }
    if (!any || here != start) {
      #pragma unroll
      for (int i = 0; i < RC_TAPS_PADDED / 16; ++i) {
        global float* to = row + (RC_ROW_PAD + start + 16 * i);
        if (any) rc_store16(vload16(0, to) + kept[i], 0, to);
        kept[i] = 0.0f;
      }
      start = here;
      any = true;
    }
    const float x = phase[k] * (float)t->phases;
    const int q = min((int)x, t->phases - 1);
    const float high = e * (x - (float)q), low = e - high;
    global const float* shares = t->taps + q * RC_TAPS_PADDED;
    #pragma unroll
    for (int i = 0; i < RC_TAPS_PADDED / 16; ++i)
      kept[i] = fma((float16)(high), vload16(i, shares + RC_TAPS_PADDED), fma((float16)(low), vload16(i, shares), kept[i]));
  }
  if (!any) return;
  #pragma unroll
  for (int i = 0; i < RC_TAPS_PADDED / 16; ++i) {
    global float* to = row + (RC_ROW_PAD + start + 16 * i);
    rc_store16(vload16(0, to) + kept[i], 0, to);
  }
}

/* What hangs over the gate's ends, added to the sums. */
static inline void rc_close_row(const LidarTables* t, global const float* row, float sums[RC_SUM_COUNT][2]) {
  float16 early = 0.0f, late = 0.0f;
  for (int i = 0; i < RC_ROW_PAD; i += 16) early += vload16(0, row + i);
  const int16 lane = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (int i = t->bins / 16 * 16; i + RC_ROW_PAD < (int)t->row; i += 16)
    late += select((float16)(0.0f), vload16(0, row + RC_ROW_PAD + i), lane + i >= t->bins);
  rc_add_float(sums[RC_SUM_EARLY], rc_lane_sum(early));
  rc_add_float(sums[RC_SUM_LATE], rc_lane_sum(late));
}

#endif
