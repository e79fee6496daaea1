/* Rows of light from the way: impulses of bins at two phases, spread by the pulse's shares in one pass. Adding bin by
 * bin, every store would overlap the next load. */
#ifndef RAYCUBE_KERNELS_LIDAR_WAY_ROWS_H
#define RAYCUBE_KERNELS_LIDAR_WAY_ROWS_H

#include "kernels/lidar/deposit.h"
#include "kernels/lidar/way_light.h"

/* Kinds of rows: air, then particles. */
static inline uint rc_way_rows(const LidarTables* t) { return RC_HAS(t, VOLUMES) ? 2u : 1u; }

/* Impulses of an owner's pixel, [kind][line][Gauss point]. */
typedef struct Impulses {
  global float* at;
  global float* share; /* of the pulse, [Gauss point][tap, padded] */
  uint floats;         /* of all impulses */
  uint line_floats;    /* of one line at one Gauss point: a row, and room for a pulse before it */
} Impulses;

static inline Impulses rc_impulses(const LidarTables* t, global float* scratch, uint owner) {
  Impulses impulses;
  impulses.line_floats = t->row + (uint)t->padded_taps;
  impulses.floats = rc_way_rows(t) * 2u * RC_LINES(t) * impulses.line_floats;
  impulses.at = scratch + (size_t)owner * (impulses.floats + 2u * (uint)t->padded_taps);
  impulses.share = impulses.at + impulses.floats;
  return impulses;
}

static inline void rc_clear_impulses(Impulses impulses) {
  for (uint i = 0; i < impulses.floats; i += 16u) rc_store16((float16)(0.0f), 0, impulses.at + i);
}

/* A kind's impulses of a line, at the first Gauss point; those at the second are line_floats further. */
static inline global float* rc_impulse_line(const LidarTables* t, Impulses impulses, uint kind, uint line) {
  return impulses.at + (kind * RC_LINES(t) + line) * 2u * impulses.line_floats;
}

/* Impulses of 16 bins, at both Gauss points, to their place by the slot where their shares start. Bins whose pulse lies
 * outside the gate are left out. */
static inline void rc_put(const LidarTables* t, Impulses impulses, uint kind, uint line, float sums[RC_SUM_COUNT][2],
                          int bin, const float16* energy) {
  const int16 start = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) + (bin + t->first_tap);
  const int16 in = (start + t->tap_count > 0) & (start < t->bins);
  const float16 a = select((float16)(0.0f), energy[0], in), b = select((float16)(0.0f), energy[1], in);
  rc_add_float(sums[RC_SUM_COLLECTED], rc_lane_sum(a + b));
  global float* to = rc_impulse_line(t, impulses, kind, line) + 2 * t->padded_taps + bin + t->first_tap;
  rc_store16(a, 0, to);
  rc_store16(b, 0, to + impulses.line_floats);
}

/* The pulse's shares of bins at the phases of the two Gauss points. */
static inline void rc_phase_shares(const LidarTables* t, Impulses impulses) {
  for (uint g = 0; g < 2u; ++g) {
    const float x = (g ? 1.0f - RC_GAUSS_POINT : RC_GAUSS_POINT) * (float)t->phases;
    const int q = min((int)x, t->phases - 1);
    for (int i = 0; i < t->padded_taps; ++i) {
      const float low = t->taps[q * t->padded_taps + i], high = t->taps[(q + 1) * t->padded_taps + i];
      impulses.share[(int)g * t->padded_taps + i] = fma(x - (float)q, high - low, low);
    }
  }
}

/* One line's impulses, spread by the shares, to its row. */
static inline void rc_spread(const LidarTables* t, Impulses impulses, uint kind, uint line, global float* row) {
  global const float *from = rc_impulse_line(t, impulses, kind, line) + t->padded_taps, *first = impulses.share,
                     *second = first + t->padded_taps;
  for (uint slot = 0; slot < t->row; slot += 16u) {
    float16 sum = 0.0f;
    for (int i = 0; i < t->tap_count; ++i) {
      global const float* at = from + (int)slot - i;
      sum = fma((float16)(first[i]), rc_load16(0, at),
                fma((float16)(second[i]), rc_load16(0, at + impulses.line_floats), sum));
    }
    rc_store16(sum, 0, row + slot);
  }
}

#endif
