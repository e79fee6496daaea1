/* Volumes along an owner's middle ray, swept cell after cell. */
#ifndef RAYCUBE_KERNELS_LIDAR_WAY_SWEEP_H
#define RAYCUBE_KERNELS_LIDAR_WAY_SWEEP_H

#include "kernels/lidar/media.h"
#include "kernels/lidar/way_cells.h"

/* How far a chain of cells has been swept. */
typedef struct Swept {
  float came_to, too_far; /* m from RC_SHOT_GATE, and how much rounding added to it */
  float depth[RC_MOST_LINE_NODES],
      lost[RC_MOST_LINE_NODES]; /* and what rounding took of its sum (Kahan): 1e-4 of it over 20000 bins */
} Swept;

static inline void rc_begin_sweep(const LidarTables* t, Swept* swept) {
  swept->came_to = -t->shot[RC_SHOT_GATE].w;
  swept->too_far = 0.0f;
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) swept->depth[node] = swept->lost[node] = 0.0f;
}

static inline void rc_deepen(Swept* swept, uint node, float more) {
  const float whole = more - swept->lost[node], sum = swept->depth[node] + whole;
  swept->lost[node] = (sum - swept->depth[node]) - whole;
  swept->depth[node] = sum;
}

/* Depths at the cells' Gauss points and what particles scatter in each cell, integrated over it. */
static inline void rc_sweep(const LidarTables* t, const Beam* beam, const Cells* cells, float part, Swept* swept,
                            float16* depth, float16* particles) {
  RC_LINE float s[16], span[16], scattered[16];
  RC_LINE float here[RC_MOST_LINE_NODES][16];
  const float4 gate = t->shot[RC_SHOT_GATE];
  const uint exists = rc_mask16(cells->s > 0.0f);
  rc_store16(cells->past, 0, s);
  rc_store16(cells->span, 0, span);
  for (uint k = 0; k < 16u; ++k) {
    scattered[k] = 0.0f;
    for (uint node = 0; node < RC_LINE_NODES(t); ++node) here[node][k] = swept->depth[node];
    if (!(exists >> k & 1u)) continue;
    const float from = fmax(s[k] - part * span[k], -gate.w), before = (from - swept->came_to) + swept->too_far;
    const float4 at = (float4)(gate.xyz, 0.0f) + from * beam->way;
    float cell[RC_MOST_LINE_NODES];
    for (uint node = 0; node < RC_LINE_NODES(t); ++node) cell[node] = 0.0f;
    for (uint i = 0; i < t->volume_count; ++i) {
      if (before > 0.01f * span[k]) { /* the first cell begins past the start */
        const float gap = rc_volume_path(t->volumes + i, t->volume_values, at, beam->way, -before, 0.0f);
        for (uint node = 0; node < RC_LINE_NODES(t); ++node) rc_deepen(swept, node, rc_volume_depth(t, i, node, gap));
      }
      const float field = rc_volume_path(t->volumes + i, t->volume_values, at, beam->way, 0.0f, span[k]);
      scattered[k] +=
          t->volumes[i].particles.x > 0.0f ? field * t->volumes[i].particles.x / t->volumes[i].particles.z : 0.0f;
      for (uint node = 0; node < RC_LINE_NODES(t); ++node) cell[node] += rc_volume_depth(t, i, node, field);
    }
    for (uint node = 0; node < RC_LINE_NODES(t); ++node) {
      here[node][k] = fma(part, cell[node], swept->depth[node]);
      rc_deepen(swept, node, cell[node]);
    }
    swept->came_to = from + span[k];
    swept->too_far = (swept->came_to - from) - span[k];
  }
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) depth[node] += rc_load16(0, here[node]);
  *particles = rc_load16(0, scattered);
}

#endif
