/* resolve: from a pixel's row of (product key, sums) to its list of (row of the band table, weight).
 * Reads:  rows of shade, the sorted table of baked keys, rows and weights of the pixel's environment, the glow of
 * trace_bounce. Writes: term count and terms. Next: integrate_bands. Terms come in key order (the path row first, then
 * the environment's up to four rows; last the skeleton's), channels ascending: row numbers and eviction cannot change a
 * sum. One work-item per pixel, any local size. */
#pragma OPENCL FP_CONTRACT OFF
#include "kernels/atmosphere/nodes.h"
#include "kernels/shading/sums.h"
#include "kernels/shared/camera_arguments.h"

/* Row of a key by binary search over the sorted keys of the band table. The host has baked every key of the tile. */
inline uint baked_row(__global const ulong* baked_keys, __global const uint* baked_rows, uint baked_count, ulong key) {
  uint lo = 0, hi = baked_count - 1;
  while (lo < hi) {
    const uint mid = (lo + hi) / 2;
    if (baked_keys[mid] < key)
      lo = mid + 1;
    else
      hi = mid;
  }
  return baked_rows[lo];
}

/* Of the two nodes that a value lies between, at a fraction f: the weight of the first (step 0) and of the next. Loops
 * go over these two alone: over all nodes of an axis, most with a weight of 0, NVIDIA's compiler (driver 580) unrolled
 * them wrongly, and path radiance was off by tenths where a plan had two heights and two views. */
inline float weight_of(int step, float f) { return step == 0 ? 1.0f - f : f; }

RC_BODY resolve_body(uint index, RC_PARAMETERS(RC_RESOLVE_ARGUMENTS)) {
  const uint item = first_item + index;
  if (item >= first_item + item_count) return;
  const uint pixel = use_list ? pixel_list[item] : item;
  const uint keys_used = row_count[item];
  if (keys_used == RC_ROW_OVERFLOW) {
    term_count[item] = 0;
    return;
  }
  __global const ulong* keys = row_keys + (size_t)item * capacity;
  __global const float* sums = row_sums + rc_sums_at(&tile, item, capacity);
  __global const float* path = path_sums + rc_path_at(&tile, item);
  __global uint* rows = term_row + (size_t)item * term_capacity;
  __global float* weights = term_weight + (size_t)item * term_capacity;

  /* View geometry of the pixel's centre ray. */
  __global const RayGroup* group = groups + rc_group_of(pixel, columns, tile.pixels_per_group);
  const float a = rc_place_in_group(pixel, columns, tile.pixels_per_group);
  const float dx = fma(a, group->du.x, group->d0.x), dy = fma(a, group->du.y, group->d0.y);
  const float dz = fma(a, group->du.z, group->d0.z);
  const float length = sqrt(fma(dx, dx, fma(dy, dy, dz * dz)));
  int iv, ix, iy;
  float fv, fx, fy;
  rc_node_weights(-length / dz, view_first, view_step, (int)tile.views, &iv, &fv);
  rc_node_weights(-dx / length, path_x_first, path_x_step, (int)tile.path_x, &ix, &fx);
  rc_node_weights(-dy / length, path_y_first, path_y_step, (int)tile.path_y, &iy, &fy);

  uint n = 0;
  const uint path_base = baked_row(baked_keys, baked_rows, baked_count, 0ul) * tile.channels;
  for (uint h = 0; h < tile.heights; ++h) {
    const float sum = rc_sum_of(&tile, path, tile.heights, h);
    for (int y = 0; y < min(2, (int)tile.path_y); ++y)
      for (int x = 0; x < min(2, (int)tile.path_x); ++x) {
        const float w = sum * (weight_of(x, fx) * weight_of(y, fy));
        if (w == 0.0f) continue;
        rows[n] = path_base + (h * tile.path_y + (uint)(iy + y)) * tile.path_x + (uint)(ix + x);
        weights[n++] = w;
      }
  }
  /* Light of the ground around: it reaches the sensor beside the direct path, so every sample has it, as path radiance.
   * */
  for (uint node = 0; node < environment_nodes; ++node) {
    const float share = environment_weight[item * RC_ENVIRONMENT_NODES + node];
    if (share == 0.0f) continue;
    const uint base = environment_row[item * RC_ENVIRONMENT_NODES + node] * tile.channels;
    for (uint h = 0; h < tile.heights; ++h) {
      const float sum = rc_sum_of(&tile, path, tile.heights, h);
      for (int v = 0; v < min(2, (int)tile.views); ++v) {
        const float w = sum * (share * weight_of(v, fv));
        if (w == 0.0f) continue;
        rows[n] = base + h * tile.views + (uint)(iv + v);
        weights[n++] = w;
      }
    }
  }
  /* Keys ascending: each time the smallest key above the last one. Rows are short. */
  const uint count = rc_accumulators(&tile);
  ulong last = 0ul;
  for (uint used = 0; used < keys_used; ++used) {
    uint best = 0;
    ulong key = ~0ul;
    for (uint k = 0; k < keys_used; ++k)
      if (keys[k] > last && keys[k] < key) key = keys[k], best = k;
    last = key;
    __global const float* row = sums + rc_sums_of_key(&tile, best);
    const uint base = baked_row(baked_keys, baked_rows, baked_count, key) * tile.channels;
    for (uint i = 0; i < count - 1u; ++i) {
      const float sum = rc_sum_of(&tile, row, count, i);
      for (int v = 0; v < min(2, (int)tile.views); ++v) {
        const float w = sum * weight_of(v, fv);
        if (w == 0.0f) continue;
        rows[n] = base + i * tile.views + (uint)(iv + v);
        weights[n++] = w;
      }
    }
    if (tile.covers) {
      rows[n] = base + (count - 1u) * tile.views;
      weights[n++] = rc_sum_of(&tile, row, count, count - 1u);
    }
  }
  /* Light between surfaces, where there is any: the pixel's own mean over the height nodes stands for where it was
   * scattered last. */
  for (uint row = 0; row < (1u + tile.lamps) * skeleton_rows; ++row) {
    const uint m = row / skeleton_rows * tile.skeleton + row % skeleton_rows;
    float sum = 0.0f;
    for (uint part = 0; part < RC_PATH_PARTS; ++part) sum += glow[rc_glow_at(&tile, pixel, part) + m];
    if (glow_part < RC_PATH_PARTS)
      sum = fma(glow_spread, fma(glow_scale, glow[rc_glow_at(&tile, pixel, glow_part) + m], -sum), sum);
    for (uint h = 0; h < tile.heights; ++h)
      for (int v = 0; v < min(2, (int)tile.views); ++v) {
        const float w = sum * (rc_sum_of(&tile, path, tile.heights, h) * weight_of(v, fv));
        if (w == 0.0f) continue;
        rows[n] = (skeleton_row + row) * tile.channels + h * tile.views + (uint)(iv + v);
        weights[n++] = w;
      }
  }
  term_count[item] = n;
}

kernel void resolve(RC_PARAMETERS(RC_RESOLVE_ARGUMENTS)) {
  resolve_body((uint)get_global_id(0), RC_PASSED(RC_RESOLVE_ARGUMENTS));
}
