/* Light that air and particles send back from the whole way, 16 bins side by side, at the two Gauss points of each. */
#ifndef RAYCUBE_KERNELS_LIDAR_WAY_LIGHT_H
#define RAYCUBE_KERNELS_LIDAR_WAY_LIGHT_H

#include "kernels/lidar/way_air.h"
#include "kernels/lidar/way_sweep.h"

/* Photons of 16 bins, [line][Gauss point]. */
typedef struct WayLight {
  float16 air[RC_MOST_LINES][2], particles[RC_MOST_LINES][2];
} WayLight;

/* Rays that surfaces have stopped on the way, of the pixel or of the owner: a running count. */
typedef struct Stopped {
  global const float* rows; /* [line][row] */
  float one;                /* share of one ray */
  float ended[RC_MOST_LINES];
} Stopped;

static inline Stopped rc_begin_stopped(const LidarTables* t, global const float* of_owner, uint pixel) {
  const bool own_rays = rc_stops_by_pixel(t);
  const size_t rows = (size_t)RC_OWN_PIXELS(t) * RC_LINES(t);
  Stopped stopped;
  stopped.rows = of_owner + (own_rays ? (size_t)pixel * RC_LINES(t) * t->row : 0);
  stopped.one = 1.0f / (own_rays ? fmax(of_owner[rows * t->row + pixel], 1.0f) : (float)t->rays);
  for (uint line = 0; line < RC_LINES(t); ++line) stopped.ended[line] = 0.0f;
  return stopped;
}

/* Share of the rays that still lights bins `bin` to bin + 15. */
static inline void rc_still_lit(const LidarTables* t, Stopped* stopped, int bin, float16* lit) {
  for (uint line = 0; line < RC_LINES(t); ++line) {
    RC_LINE float lane[16];
    for (uint k = 0; k < 16u; ++k) {
      const int slot = bin + (int)k + t->padded_taps;
      if (slot < (int)t->row) stopped->ended[line] += stopped->rows[line * t->row + slot];
      lane[k] = stopped->ended[line];
    }
    lit[line] = fmax(1.0f - rc_load16(0, lane) * stopped->one, 0.0f);
  }
}

/* Adds depths of the way from the cells on to the end, which is the way out again where both ends are one point. z:
 * heights of the cells' Gauss points. */
static inline void rc_add_way_back(const LidarTables* t, const Beam* beam, const Cells* cells, float16 z,
                                   float16* depth) {
  if (!(beam->squared > 0.0f)) {
    for (uint node = 0; node < RC_LINE_NODES(t); ++node) depth[node] *= 2.0f;
    return;
  }
  if (RC_HAS(t, AIR)) rc_way_depths(t, beam->start.z - beam->apart.z, z, cells->rest, depth);
  if (!RC_HAS(t, VOLUMES)) return;
  const float16 inverse = 1.0f / cells->rest;
  const float4 end_at = beam->start - beam->apart;
  const Vector16 end = {(float16)(end_at.x), (float16)(end_at.y), (float16)(end_at.z)};
  const Vector16 unit = {-fma(cells->s, (float16)(beam->way.x), (float16)(beam->apart.x)) * inverse,
                         -fma(cells->s, (float16)(beam->way.y), (float16)(beam->apart.y)) * inverse,
                         -fma(cells->s, (float16)(beam->way.z), (float16)(beam->apart.z)) * inverse};
  rc_volume_depths(t, end, unit, cells->rest, rc_mask16(cells->good), depth);
}

/* What the cells at Gauss point g of 16 bins send back. table: the pixel's of its beam; lit: share of rays that get
 * there; swept: of the chain of such cells. */
static inline void rc_way_light(const LidarTables* t, const Beam* beam, global const float* table,
                                global const float* backscatter, const float16* lit, int bin, uint g, Swept* swept,
                                WayLight* light) {
  const float part = g ? 1.0f - RC_GAUSS_POINT : RC_GAUSS_POINT;
  const Cells cells = rc_cells(t, beam, bin, part);
  const float16 geometry = rc_geometry(t, table, &cells);
  const float16 z = fma(cells.past, (float16)(beam->way.z), (float16)(t->shot[RC_SHOT_GATE].z));
  float16 depth[RC_MOST_LINE_NODES];
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) depth[node] = 0.0f;
  if (RC_HAS(t, AIR)) rc_way_depths(t, beam->start.z, z, cells.s, depth);
  float16 particles = 0.0f;
  if (RC_HAS(t, VOLUMES)) rc_sweep(t, beam, &cells, g ? 2.0f * part - 1.0f : 2.0f * part, swept, depth, &particles);
  rc_add_way_back(t, beam, &cells, z, depth);
  const float weight = t->shot[RC_SHOT_DU].w;
  for (uint line = 0; line < RC_LINES(t); ++line) {
    const float16 arrives = geometry * (weight * t->photons[line]) * rc_line_transmission(t, line, depth) * lit[line];
    light->air[line][g] = light->particles[line][g] = 0.0f;
    if (RC_HAS(t, RETURN))
      light->air[line][g] =
          arrives * cells.span * rc_backscatter(t, backscatter + line * (uint)t->settings[RC_SET_AIR_POSTS], z);
    if (RC_HAS(t, VOLUMES)) light->particles[line][g] = arrives * particles;
  }
}

#endif
