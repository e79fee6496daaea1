/* The air along an owner's middle ray: what it sends back and what it takes away. */
#ifndef RAYCUBE_KERNELS_LIDAR_WAY_AIR_H
#define RAYCUBE_KERNELS_LIDAR_WAY_AIR_H

#include "kernels/lidar/air.h"

/* Backscatter of the air at heights, 1 / (m sr): linear between posts, nothing above the last. */
static inline float16 rc_backscatter(const LidarTables* t, global const float* posts, float16 z) {
  const float last = t->settings[RC_SET_AIR_POSTS] - 1.0f;
  const float16 x = (z - t->settings[RC_SET_AIR_Z0]) / t->settings[RC_SET_AIR_DZ], at = clamp(x, 0.0f, last),
                low = fmin(floor(at), fmax(last - 1.0f, 0.0f));
  RC_LINE float lane[16], from[16], to[16];
  rc_store16(low, 0, lane);
  if (lane[0] == lane[15]) { /* heights rise or fall along the ray */
    const uint i = (uint)lane[0];
    const float low_value = posts[i], high_value = last > 0.0f ? posts[i + 1u] : low_value;
    return select(fma(at - low, (float16)(high_value - low_value), (float16)(low_value)), (float16)(0.0f), x > last);
  }
  for (uint k = 0; k < 16u; ++k) {
    const uint i = (uint)lane[k];
    from[k] = posts[i];
    to[k] = last > 0.0f ? posts[i + 1u] : posts[i];
  }
  return select(fma(at - low, rc_load16(0, to) - rc_load16(0, from), rc_load16(0, from)), (float16)(0.0f), x > last);
}

/* Adds depths from a height on the ray's own way: rc_air_depths, quickly where all 16 heights lie in one cell. */
static inline void rc_way_depths(const LidarTables* t, float from_z, float16 to_z, float16 length, float16* depth) {
  const float z0 = t->settings[RC_SET_AIR_Z0], dz = t->settings[RC_SET_AIR_DZ];
  const uint posts = (uint)t->settings[RC_SET_AIR_POSTS];
  RC_LINE float z[16];
  rc_store16(to_z, 0, z);
  const int start = rc_air_cell(from_z, z0, dz, posts), a = rc_air_cell(z[0], z0, dz, posts),
            b = rc_air_cell(z[15], z0, dz, posts);
  if (a != b) {
    rc_air_depths(t, (float16)(from_z), to_z, length, depth);
    return;
  }
  const bool up = a > start;
  const int low = min(a, start), high = max(a, start);
  const float above_low = z0 + dz * (float)(low + 1), below_high = z0 + dz * (float)high;
  const float16 first = above_low - (up ? (float16)(from_z) : to_z),
                last = (up ? to_z : (float16)(from_z)) - below_high;
  const float16 whole = (first + last) + (below_high - above_low);
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) {
    global const float2* cells = t->air + node * posts;
    if (low == high)
      depth[node] = fma(length, (float16)(cells[low].y), depth[node]);
    else
      depth[node] += length *
                     fma(first, (float16)(cells[low].y),
                         fma(last, (float16)(cells[high].y), (float16)(cells[high].x - cells[low + 1].x))) /
                     whole;
  }
}

#endif
