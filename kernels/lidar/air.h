/* Extinction depth of the air along straight segments. */
#ifndef RAYCUBE_KERNELS_LIDAR_AIR_H
#define RAYCUBE_KERNELS_LIDAR_AIR_H

#include "kernels/lidar/context.h"

static inline int rc_air_cell(float z, float z0, float dz, uint posts) {
  return (int)clamp(floor((z - z0) / dz), 0.0f, (float)(posts - 1u));
}

/* Mean extinction, 1 / m, of a node between two heights. Differences of depth only over whole cells, the rest by the
 * cells' own extinction: a level segment is right. Below the first post its cell goes on, above the last there is
 * nothing. */
static inline float rc_air_mean(global const float2* air, float z0, float dz, float low, float high, int low_cell,
                                int high_cell) {
  if (low_cell == high_cell) return air[low_cell].y;
  const float above_low = z0 + dz * (float)(low_cell + 1), below_high = z0 + dz * (float)high_cell;
  const float first = above_low - low, middle = below_high - above_low, last = high - below_high;
  return (first * air[low_cell].y + (air[high_cell].x - air[low_cell + 1].x) + last * air[high_cell].y) /
         (first + middle + last);
}

/* Adds the depths of 16 segments between heights, `length` m each, to depth[node]. */
__attribute__((noinline, unused)) static void rc_air_depths(const LidarTables* t, float16 from_z, float16 to_z,
                                                            float16 length, float16* depth) {
  RC_LINE float low[16], high[16];
  RC_LINE float mean[RC_MOST_LINE_NODES][16];
  rc_store16(fmin(from_z, to_z), 0, low);
  rc_store16(fmax(from_z, to_z), 0, high);
  const float z0 = t->settings[RC_SET_AIR_Z0], dz = t->settings[RC_SET_AIR_DZ];
  const uint posts = (uint)t->settings[RC_SET_AIR_POSTS];
  for (uint k = 0; k < 16u; ++k) {
    const int a = rc_air_cell(low[k], z0, dz, posts), b = rc_air_cell(high[k], z0, dz, posts);
    for (uint node = 0; node < RC_LINE_NODES(t); ++node)
      mean[node][k] = rc_air_mean(t->air + node * posts, z0, dz, low[k], high[k], a, b);
  }
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) depth[node] = fma(length, rc_load16(0, mean[node]), depth[node]);
}

/* What the nodes of a line let through; nodes are averaged after the exponential. */
static inline float16 rc_line_transmission(const LidarTables* t, uint line, const float16* depth) {
  float16 sum = 0.0f;
  const uint end = t->first_node[line + 1u];
  for (uint node = t->first_node[line]; node < end; ++node)
    sum = fma((float16)(t->node_weight[node]), exp(-depth[node]), sum);
  return sum;
}

#endif
