/* Extinction depth of air and volumes along straight segments: the one place that both are asked. */
#ifndef RAYCUBE_KERNELS_LIDAR_MEDIA_H
#define RAYCUBE_KERNELS_LIDAR_MEDIA_H

#include "kernels/geometry/surface_point.h"
#include "kernels/lidar/air.h"
#include "kernels/lidar/volume.h"

/* Depth of a node for a volume's field integral, m (a plume: g/m2). */
static inline float rc_volume_depth(const LidarTables* t, uint volume, uint node, float field) {
  global const LidarVolume* v = t->volumes + volume;
  return field * fma(v->strength.x, t->volume_depth[volume * RC_LINE_NODES(t) + node], v->particles.x);
}

/* Adds the volumes' depths along the last `length` m of ways that end at `to` (scene frame), of the lanes in `live`. */
__attribute__((noinline, unused)) static void rc_volume_depths(const LidarTables* t, Vector16 to, Vector16 unit,
                                                               float16 length, uint live, float16* depth) {
  RC_LINE float lane[7][16];
  RC_LINE float sum[RC_MOST_LINE_NODES][16];
  rc_store16(to.x, 0, lane[0]);
  rc_store16(to.y, 0, lane[1]);
  rc_store16(to.z, 0, lane[2]);
  rc_store16(unit.x, 0, lane[3]);
  rc_store16(unit.y, 0, lane[4]);
  rc_store16(unit.z, 0, lane[5]);
  rc_store16(length, 0, lane[6]);
  for (uint k = 0; k < 16u; ++k) {
    for (uint node = 0; node < RC_LINE_NODES(t); ++node) sum[node][k] = 0.0f;
    if (!(live >> k & 1u)) continue;
    for (uint i = 0; i < t->volume_count; ++i) {
      const float field =
          rc_volume_path(t->volumes + i, t->volume_values, (float4)(lane[0][k], lane[1][k], lane[2][k], 0.0f),
                         (float4)(lane[3][k], lane[4][k], lane[5][k], 0.0f), -lane[6][k], 0.0f);
      for (uint node = 0; node < RC_LINE_NODES(t); ++node) sum[node][k] += rc_volume_depth(t, i, node, field);
    }
  }
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) depth[node] += rc_load16(0, sum[node]);
}

#endif
