/* Puts a pulse of some energy at its place in a row of bins. */
#ifndef RAYCUBE_KERNELS_LIDAR_DEPOSIT_H
#define RAYCUBE_KERNELS_LIDAR_DEPOSIT_H

#include "kernels/lidar/context.h"

/* Adds to bins that are sums of two floats, the rests as far behind as the owner's rows are long: Knuth's two-sum, as
 * rc_add_float's. */
static inline void rc_add_bins(const LidarTables* t, RC_ROW_SPACE float* to, float16 more) {
  RC_ROW_SPACE float* rest = to + rc_own_floats(t);
  const float16 before = rc_load16(0, to), after = before + more, taken = after - before;
  rc_store16(rc_load16(0, rest) + ((before - (after - taken)) + (more - taken)), 0, rest);
  rc_store16(after, 0, to);
}

/* bin + phase (0 <= phase < 1): position of the pulse's centre. */
static inline void rc_deposit(const LidarTables* t, RC_ROW_SPACE float* row, float sums[RC_SUM_COUNT][2], int bin,
                              float phase, float energy) {
  const int start = bin + t->first_tap;
  if (start + t->tap_count <= 0) {
    rc_add_float(sums[RC_SUM_EARLY], energy);
  } else if (start >= t->bins) {
    rc_add_float(sums[RC_SUM_LATE], energy);
  } else {
    const float x = phase * (float)t->phases;
    const int q = min((int)x, t->phases - 1);
    const float f = x - (float)q;
    global const float* low = t->taps + q * t->padded_taps;
    RC_ROW_SPACE float* to = row + (t->padded_taps + start);
    for (int i = 0; i < t->padded_taps; i += 16) {
      const float16 a = rc_load16(0, low + i), b = rc_load16(0, low + t->padded_taps + i),
                    share = fma((float16)(f), b - a, a);
      if (RC_HAS(t, RESTS))
        rc_add_bins(t, to + i, share * energy);
      else
        rc_store16(fma((float16)(energy), share, rc_load16(0, to + i)), 0, to + i);
    }
  }
}

/* The lanes whose pulses reach into the gate; the others' energy goes to the sums. start: bins of their first taps. */
static inline uint rc_in_gate(const LidarTables* t, float sums[RC_SUM_COUNT][2], uint lanes, int16 start,
                              float16 energy) {
  const int16 begins_early = start + t->tap_count <= 0, begins_late = start >= t->bins;
  const uint early = rc_mask16(begins_early) & lanes, late = rc_mask16(begins_late) & lanes;
  if (early | late) {
    rc_add_float(sums[RC_SUM_EARLY], rc_lane_sum(select((float16)(0.0f), energy, rc_bits16(early))));
    rc_add_float(sums[RC_SUM_LATE], rc_lane_sum(select((float16)(0.0f), energy, rc_bits16(late & ~early))));
  }
  return lanes & ~(early | late);
}

/* The same for lanes of a word, one after the other, into one row. Neighbours mostly fall into the same bins: these are
 * kept in registers until another start comes. bin, phase: as above; energy: 0 in lanes that send nothing. */
static inline void rc_deposit_lanes(const LidarTables* t, RC_ROW_SPACE float* row, float sums[RC_SUM_COUNT][2],
                                    uint lanes, int16 bin, float16 phase, float16 energy) {
  const int16 start_lanes = bin + t->first_tap;
  lanes = rc_in_gate(t, sums, lanes, start_lanes, energy);
  if (!lanes) return;
  const float16 x = phase * (float)t->phases;
  const int16 q = min(convert_int16(x), (int16)(t->phases - 1)); /* oclgrind takes scalars for lane 0 alone */
  const float16 high_lanes = energy * (x - convert_float16(q));
  RC_LINE float high[16], low[16];
  RC_LINE int starts[16], shares[16];
  rc_store16(high_lanes, 0, high);
  rc_store16(energy - high_lanes, 0, low);
  rc_store16(as_float16(start_lanes), 0, (float*)starts);
  rc_store16(as_float16(q * t->padded_taps), 0, (float*)shares);
  while (lanes) {
    const int start = starts[rc_lowest(lanes)];
    RC_ROW_SPACE float* to = row + (t->padded_taps + start);
    const uint here = rc_mask16(start_lanes == start) & lanes;
    lanes &= ~here;
    for (int i = 0; i < t->padded_taps; i += 16) {
      /* Two sums, of lower and upper phases: half as long a chain of additions. */
      float16 kept = RC_HAS(t, RESTS) ? (float16)(0.0f) : rc_load16(0, to + i), kept_high = 0.0f;
      for (uint left = here; left; left &= left - 1u) {
        const uint k = rc_lowest(left);
        global const float* at = t->taps + shares[k] + i;
        kept = fma((float16)(low[k]), rc_load16(0, at), kept);
        kept_high = fma((float16)(high[k]), rc_load16(0, at + t->padded_taps), kept_high);
      }
      if (RC_HAS(t, RESTS))
        rc_add_bins(t, to + i, kept + kept_high);
      else
        rc_store16(kept + kept_high, 0, to + i);
    }
  }
}

/* What hangs over the gate's ends, added to the sums. */
static inline void rc_close_row(const LidarTables* t, RC_ROW_SPACE const float* row, float sums[RC_SUM_COUNT][2]) {
  float16 early = 0.0f, late = 0.0f;
  for (int i = 0; i < t->padded_taps; i += 16) early += rc_load16(0, row + i);
  const int16 lane = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (int i = t->bins / 16 * 16; i + t->padded_taps < (int)t->row; i += 16)
    late += select((float16)(0.0f), rc_load16(0, row + t->padded_taps + i), lane + i >= t->bins);
  rc_add_float(sums[RC_SUM_EARLY], rc_lane_sum(early));
  rc_add_float(sums[RC_SUM_LATE], rc_lane_sum(late));
}

#endif
