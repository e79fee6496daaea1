/* Cells of the whole way along an owner's middle ray, 16 bins side by side, and how much of the beam they see. */
#ifndef RAYCUBE_KERNELS_LIDAR_WAY_CELLS_H
#define RAYCUBE_KERNELS_LIDAR_WAY_CELLS_H

#include "kernels/lidar/beam.h"

#define RC_GAUSS_POINT 0.211324865f

/* 16 cells, one in each of 16 bins: Gauss points at bin + part. */
typedef struct Cells {
  float16 s, span, rest; /* m from the start; length; from the Gauss point to the end */
  float16 past; /* m, Gauss point from RC_SHOT_GATE, of small numbers alone: floats of s are 3 cm apart at 400 km */
  int16 good;
} Cells;

static inline Cells rc_cells(const LidarTables* t, const Beam* beam, int bin, float part) {
  const float16 lane =
      (float16)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f, 8.0f, 9.0f, 10.0f, 11.0f, 12.0f, 13.0f, 14.0f, 15.0f);
  const float step = 1.0f / t->settings[RC_SET_BINS_PER_M];
  const float16 bins = lane + ((float)bin + part),
                whole = fma(bins, (float16)(step), (float16)(t->settings[RC_SET_GATE_WAY]));
  const float4 at_gate = t->shot[RC_SHOT_GATE_WAY];
  Cells cells;
  cells.s = rc_beam_distance(beam, fmax(whole, 0.0f));
  /* s = (whole - along) / 2 - beside / (2 (whole + along)), its difference from the gate's. */
  const float16 both = fmax((whole + beam->along) * (at_gate.x + beam->along), 1e-20f);
  cells.past = 0.5f * step * (bins - at_gate.y) * (1.0f + beam->beside / both);
  cells.rest = fmax(whole - cells.s, 1e-20f);
  /* d whole / d s = 1 + the cosine between the ray and the way back from the end. */
  cells.span = 0.5f * step / fmax(1.0f + (cells.s + beam->along) / cells.rest, 1e-6f);
  cells.good = (cells.s > 0.0f) & (cells.s <= t->settings[RC_SET_RANGE_LIMIT]) &
               ((RC_HAS(t, RECEIVER) ? cells.s : cells.rest) >= t->settings[RC_SET_MINIMUM_RANGE]);
  return cells;
}

/* The table at distances, over the square of the distance to the end. */
static inline float16 rc_geometry(const LidarTables* t, global const float* table, const Cells* cells) {
  const float log_near = table[RC_BEAM_LOG_NEAR], per_log = table[RC_BEAM_POSTS_PER_LOG];
  const float16 at = clamp((log(fmax(cells->s, 1e-20f)) - log_near) * per_log, 0.0f, table[RC_BEAM_LAST]),
                low = floor(at);
  RC_LINE float lane[16], from[16], to[16];
  rc_store16(low, 0, lane);
  float16 a, b;
  if (lane[0] == lane[15]) { /* distances rise */
    a = table[(uint)lane[0]];
    b = table[(uint)lane[0] + 1u];
  } else {
    for (uint k = 0; k < 16u; ++k) {
      const uint post = (uint)lane[k];
      from[k] = table[post];
      to[k] = table[post + 1u];
    }
    a = rc_load16(0, from);
    b = rc_load16(0, to);
  }
  int16 open = cells->good;
  /* Where nothing is seen from one of two posts, the edge of a blind zone lies between: nothing leaks into it. */
  if (RC_HAS(t, OVERLAP) && !RC_HAS(t, RECEIVER) && !RC_HAS(t, PIXELS)) open &= (a > 0.0f) & (b > 0.0f);
  /* Nearer than the table: eta / R^2 stays. */
  const float16 rest = cells->rest * fmax(exp(log_near) / fmax(cells->s, 1e-20f), 1.0f);
  return select((float16)(0.0f), fma(at - low, b - a, a) / (rest * rest), open);
}

#endif
