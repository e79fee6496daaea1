/* Rows and sums of an owner: emptied before its rays are traced, closed after. */
#ifndef RAYCUBE_KERNELS_LIDAR_OWNER_ROWS_H
#define RAYCUBE_KERNELS_LIDAR_OWNER_ROWS_H

#include "kernels/lidar/deposit.h"

/* A store to memory that is read much later. */
#if defined(__has_builtin)
#if __has_builtin(__builtin_nontemporal_store)
#define RC_STORE_ONCE(value, to) __builtin_nontemporal_store((value), (to))
#endif
#endif
#ifndef RC_STORE_ONCE
#define RC_STORE_ONCE(value, to) *(to) = (value)
#endif

/* Where an owner's rows are added up: [pixel][line][row]. */
typedef struct OwnerRows {
  RC_ROW_SPACE float *first, *multiple; /* scattered once, and more often (RC_FEATURE_BOUNCES) */
  global float* stopped;                /* RC_FEATURE_STOPPED */
} OwnerRows;

static inline void rc_clear_sums(const LidarTables* t, LidarSums* total) {
  total->rays = 0;
  for (uint line = 0; line < RC_LINES(t); ++line) {
    for (uint i = 0; i < RC_SUM_COUNT; ++i) total->sum[line][i][0] = total->sum[line][i][1] = 0.0f;
    for (uint i = 0; i < RC_LEDGER_COUNT; ++i) total->ledger[line][i] = 0;
  }
}

static inline void rc_clear_rows(const LidarTables* t, const OwnerRows* own) {
  for (size_t i = 0; i < rc_floats_of_sum(t) * rc_own_floats(t); i += 16) {
    rc_store16((float16)(0.0f), 0, own->first + i);
    if (RC_HAS(t, BOUNCES)) rc_store16((float16)(0.0f), 0, own->multiple + i);
  }
  if (RC_HAS(t, STOPPED))
    for (size_t i = 0; i < (rc_stops_by_pixel(t) ? rc_stopped_floats(t) : (size_t)RC_LINES(t) * t->row); i += 16)
      rc_store16((float16)(0.0f), 0, own->stopped + i);
}

static inline void rc_add_rests(const LidarTables* t, RC_ROW_SPACE float* rows) {
  const size_t floats = rc_own_floats(t);
  for (size_t i = 0; i < floats; i += 16)
    rc_store16(rc_load16(0, rows + i) + rc_load16(0, rows + floats + i), 0, rows + i);
}

/* Bins get their rests; what hangs over the gate's ends of all rows goes into their lines' sums. */
static inline void rc_close_rows(const LidarTables* t, const OwnerRows* own, LidarSums* total) {
  if (RC_HAS(t, RESTS)) {
    rc_add_rests(t, own->first);
    if (RC_HAS(t, BOUNCES)) rc_add_rests(t, own->multiple);
  }
  for (uint line = 0; line < RC_LINES(t); ++line)
    for (uint pixel = 0; pixel < RC_OWN_PIXELS(t); ++pixel) {
      const size_t row = (size_t)(pixel * RC_LINES(t) + line) * t->row;
      rc_close_row(t, own->first + row, total->sum[line]);
      if (RC_HAS(t, BOUNCES)) rc_close_row(t, own->multiple + row, total->sum[line]);
    }
}

#if RC_ROW_WINDOW
/* Rows to come lie in no cache: whole lines go there once, past the caches, and nothing waits for what was there. */
static inline void rc_store_window(const LidarTables* t, private const float* window, global float* first) {
  global float16* to = (global float16*)first;
  for (size_t i = 0; i < rc_own_floats(t); i += 16)
    RC_STORE_ONCE(rc_load16(0, window + i), to + i / 16);
}
#endif

#endif
