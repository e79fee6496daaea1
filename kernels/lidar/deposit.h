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

/* What hangs over the gate's ends, added to the sums. */
static inline void rc_close_row(const LidarTables* t, global const float* row, float sums[RC_SUM_COUNT][2]) {
  for (int i = 0; i < RC_ROW_PAD; ++i) rc_add_float(sums[RC_SUM_EARLY], row[i]);
  for (int i = RC_ROW_PAD + t->bins; i < (int)t->row; ++i) rc_add_float(sums[RC_SUM_LATE], row[i]);
}

#endif
