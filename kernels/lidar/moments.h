/* Pulses of many rays into one row. What falls into one cell of a bin is kept as moments of its place there, a word's
 * lanes side by side, and meets the pulse's shape once an owner (or when another cell takes its slot): whatever the
 * number of rays, as many additions of whole pulses as cells that light falls into. host/lidar/pulse_moments.h. */
#ifndef RAYCUBE_KERNELS_LIDAR_MOMENTS_H
#define RAYCUBE_KERNELS_LIDAR_MOMENTS_H

#include "kernels/lidar/deposit.h"

#define RC_MOMENT_SLOTS 16u
#define RC_MOMENT_WORDS 16u
/* Words that are added up before their sums go to the row: of 65 536 sub-rays as many sums, which a float of all of
 * them would hold to 5e-5 alone, and blocks of them to 1e-6. */
#define RC_MOMENT_BLOCK 64u
/* Lines of an owner whose hits are folded, at most. */
#define RC_MOST_FOLDED (RC_MOST_LINES < RC_FOLDED_LINES ? RC_MOST_LINES : RC_FOLDED_LINES)

typedef struct Moments {
  float sum[RC_MOMENT_SLOTS][16 * RC_MOMENTS];
  uint cell[RC_MOMENT_SLOTS];  /* from the row's first float on; RC_NONE: free */
  uint words[RC_MOMENT_SLOTS]; /* added to the slot's sums */
  /* Words that wait. How many cells one has is a branch that no processor foretells: it is taken when what it hangs on
   * is long known, and the paths before it do not stop there. */
  uint waiting_cell[RC_MOMENT_WORDS][16]; /* RC_NONE: nothing in the lane */
  float waiting_y[RC_MOMENT_WORDS][16], waiting_energy[RC_MOMENT_WORDS][16];
  uint waiting;
} RC_LINE Moments;

/* Of a cell: neighbours in a bin and bins one after the other both have slots of their own. */
static inline uint rc_slot_of(uint cell) { return (cell ^ cell >> 4) % RC_MOMENT_SLOTS; }

static inline void rc_clear_moments(Moments* kept) {
  for (uint slot = 0; slot < RC_MOMENT_SLOTS; ++slot) kept->cell[slot] = RC_NONE;
  kept->waiting = 0;
}

/* What a slot holds to the row, and to what is collected; the slot is free then. */
static inline void rc_fold(const LidarTables* t, Moments* kept, uint slot, RC_ROW_SPACE float* row,
                           float sums[RC_SUM_COUNT][2]) {
  const uint cell = kept->cell[slot], cells = (uint)t->cells, start = cell / cells;
  float moment[RC_MOMENTS];
#pragma unroll
  for (uint k = 0; k < RC_MOMENTS; ++k) moment[k] = rc_lane_sum(rc_load16(k, kept->sum[slot]));
  global const float* at =
      t->taps + (size_t)(uint)(t->phases + 1 + (int)(cell - start * cells) * RC_MOMENTS) * (uint)t->padded_taps;
  RC_ROW_SPACE float* to = row + start;
  for (int i = 0; i < t->padded_taps; i += 16) {
    float16 sum = rc_load16(0, to + i);
#pragma unroll
    for (uint k = 0; k < RC_MOMENTS; ++k)
      sum = fma((float16)(moment[k]), rc_load16(0, at + k * (uint)t->padded_taps + i), sum);
    rc_store16(sum, 0, to + i);
  }
  rc_add_float(sums[RC_SUM_COLLECTED], moment[0]);
  kept->cell[slot] = RC_NONE;
}

/* A word's lanes to their cells' slots. */
static inline void rc_sort_word(const LidarTables* t, Moments* kept, uint word, RC_ROW_SPACE float* row,
                                float sums[RC_SUM_COUNT][2]) {
  const uint16 cell = rc_load16(0, kept->waiting_cell[word]);
  const float16 y = rc_load16(0, kept->waiting_y[word]), energy = rc_load16(0, kept->waiting_energy[word]);
  uint lanes = rc_mask16(cell != RC_NONE);
  while (lanes) {
    const uint here = kept->waiting_cell[word][rc_lowest(lanes)], slot = rc_slot_of(here);
    const int16 same = cell == here;
    lanes &= ~rc_mask16(same);
    float16 moment = select((float16)(0.0f), energy, same);
   private
    float* sum = kept->sum[slot];
    if (kept->cell[slot] == here) {
#pragma unroll
      for (uint k = 0; k < RC_MOMENTS; ++k, moment *= y) rc_store16(rc_load16(k, sum) + moment, k, sum);
      if (++kept->words[slot] == RC_MOMENT_BLOCK) rc_fold(t, kept, slot, row, sums);
      continue;
    }
    if (kept->cell[slot] != RC_NONE) rc_fold(t, kept, slot, row, sums);
    kept->cell[slot] = here;
    kept->words[slot] = 1u;
#pragma unroll
    for (uint k = 0; k < RC_MOMENTS; ++k, moment *= y) rc_store16(moment, k, sum);
  }
}

static inline void rc_sort_words(const LidarTables* t, Moments* kept, RC_ROW_SPACE float* row,
                                 float sums[RC_SUM_COUNT][2]) {
  for (uint word = 0; word < kept->waiting; ++word) rc_sort_word(t, kept, word, row, sums);
  kept->waiting = 0;
}

/* All that is kept, to the row. */
static inline void rc_fold_all(const LidarTables* t, Moments* kept, RC_ROW_SPACE float* row,
                               float sums[RC_SUM_COUNT][2]) {
  rc_sort_words(t, kept, row, sums);
  for (uint slot = 0; slot < RC_MOMENT_SLOTS; ++slot)
    if (kept->cell[slot] != RC_NONE) rc_fold(t, kept, slot, row, sums);
}

/* As rc_deposit_lanes; what is collected is counted too. */
static inline void rc_keep_lanes(const LidarTables* t, Moments* kept, RC_ROW_SPACE float* row,
                                 float sums[RC_SUM_COUNT][2], uint lanes, int16 bin, float16 phase, float16 energy) {
  const int16 start = bin + t->first_tap;
  const uint in = rc_in_gate(t, sums, lanes, start, energy);
  if (in != lanes)
    rc_add_float(sums[RC_SUM_COLLECTED], rc_lane_sum(select((float16)(0.0f), energy, rc_bits16(lanes & ~in))));
  const int16 inside = rc_bits16(in);
  const float16 place = phase * (float)t->cells;
  const int16 part = min(convert_int16(place), (int16)(t->cells - 1));
  const uint word = kept->waiting;
  rc_store16(select((uint16)(RC_NONE), as_uint16((start + t->padded_taps) * t->cells + part), inside), 0,
             kept->waiting_cell[word]);
  rc_store16(select((float16)(0.0f), place - convert_float16(part) - 0.5f, inside), 0, kept->waiting_y[word]);
  rc_store16(energy, 0, kept->waiting_energy[word]);
  kept->waiting = word + 1u;
  if (kept->waiting == RC_MOMENT_WORDS) rc_sort_words(t, kept, row, sums);
}

#endif
