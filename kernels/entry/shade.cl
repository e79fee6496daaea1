/* shade: from hits, surface points, sun visibility and blocked sky to per-pixel rows of (product key, scalar sums).
 * Reads:  hits, surface and lift, sun bits, blocked sky of the tile (or of one chunk of its samples).
 * Writes: row count, keys, sums, path sums, truth sums. Next: resolve.
 * One work-item per pixel, any local size. Sums are masked float16 sums over sample groups in sample order, then one
 * fixed lane tree, so that row capacity, tile and work-group cannot change a bit. Sample weights come relative to their
 * mean, 1 for the plain box, so that a chunk's counts are exact; their number divides the chunk's sums. */
#pragma OPENCL FP_CONTRACT OFF
#include "kernels/shared/tile_layout.h"
#include "kernels/atmosphere/nodes.h"
#include "kernels/geometry/lanes.h"
#include "kernels/geometry/scene_arrays.h"
#include "kernels/geometry/lift.h"

#define SOLAR_COMPONENTS (RC_COMPONENTS - RC_THERMAL_COMPONENTS)

inline float lane_sum(float16 v) {
  const float8 a = v.lo + v.hi;
  const float4 b = a.lo + a.hi;
  const float2 c = b.lo + b.hi;
  return c.x + c.y;
}

inline float16 masked(float16 v, int16 mask) { return select((float16)(0.0f), v, mask); }

#if RC_CHUNKED
/* Neumaier's compensated addition (ZAMM 54, 1974): sum and its running error, exact to about one rounding. */
inline void add_to(__global float* sum, __global float* error, float x) {
  const float s = *sum, t = s + x;
  *error += fabs(s) >= fabs(x) ? (s - t) + x : (x - t) + s;
  *sum = t;
}
#define ADD(array, index, offset, x) add_to(&array[index], &array[(index) + (offset)], (x))
#else
#define ADD(array, index, offset, x) array[index] += (x)
#endif

/* Index of key in the row, appended when new; capacity when the row is full. */
inline uint find_key(__global ulong* keys, __global float* sums, uint* count, uint capacity, ulong key) {
  for (uint k = 0; k < *count; ++k)
    if (keys[k] == key) return k;
  if (*count == capacity) return capacity;
  keys[*count] = key;
  for (uint i = 0; i < RC_SUMS_OF_KEY(1); ++i) sums[RC_SUMS_OF_KEY(*count) + i] = 0.0f;
  return (*count)++;
}

/* The masked sums of one surface's samples, times its material fractions, into the row. Returns 0 when the row is full.
 * values: [RC_LIT * heights], then coverage. cover: coverage per height node; nodes: where each material's temperature
 * lies among the temperature nodes (both read only when there are any). */
inline int deposit(__global ulong* keys, __global float* sums, uint* count, uint capacity,
                   __global const Surface* surface, const float* values, const float* cover,
                   __global const float* nodes) {
  for (int c = 0; c < 4; ++c) {
    const float fraction = surface->fraction[c];
    if (surface->curve[c] == 0u || fraction == 0.0f) continue;
    const uint k = find_key(keys, sums, count, capacity, (ulong)surface->curve[c]);
    if (k == capacity) return 0;
    __global float* row = sums + RC_SUMS_OF_KEY(k);
    for (int i = 0; i < RC_LIT * RC_HEIGHTS; ++i) ADD(row, i, RC_ACCUMULATORS, fraction * values[i]);
#if RC_TEMPERATURES > 0
    int node;
    float share;
    rc_node_weights(nodes[c], 0.0f, 1.0f, RC_TEMPERATURES, &node, &share);
    for (int h = 0; h < RC_HEIGHTS; ++h) {
      ADD(row, (RC_LIT + node) * RC_HEIGHTS + h, RC_ACCUMULATORS, fraction * ((1.0f - share) * cover[h]));
      if (share > 0.0f) ADD(row, (RC_LIT + node + 1) * RC_HEIGHTS + h, RC_ACCUMULATORS, fraction * (share * cover[h]));
    }
#endif
    ADD(row, RC_ACCUMULATORS - 1, RC_ACCUMULATORS, fraction * values[RC_LIT * RC_HEIGHTS]);
  }
  return 1;
}

#define SHADE_PARAMETERS                                                                                          \
  uint pixel_count, global const uint *restrict pixel_list, uint use_list, uint capacity, uint fresh,             \
      global const RayGroup *restrict groups, uint columns, global const uint *restrict hits,                     \
      global const float *restrict surface_points, global const float *restrict lifts,                            \
      global const ushort *restrict sun_bits, global const float *restrict sky_blocked, RC_BLOCKS, RC_SURFACES,   \
      global const float *restrict chunk_weight, float sample_total, float4 sun_direction,                        \
      global const float4 *restrict irradiance_map, uint map_size, global const float4 *restrict tilt_irradiance, \
      global const float *restrict surface_nodes, float height_first, float height_step,                          \
      global uint *restrict row_count, global ulong *restrict row_keys, global float *restrict row_sums,          \
      global float *restrict path_sums, global float *restrict truth

RC_BODY shade_body(uint item, SHADE_PARAMETERS) {
  SceneArrays scene;
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_SURFACES(scene);
  if (item >= pixel_count) return;
  const uint pixel = use_list ? pixel_list[item] : item; /* index in the tile's inputs; outputs go by item */

  __global const uint* hit_instance = hits + RC_HITS_AT(pixel);
  __global const uint* hit_primitive = hit_instance + RC_PLANE(RC_HIT_PRIMITIVE);
  __global const float* point = surface_points + RC_SURFACE_AT(pixel);
  __global const float* lift = lifts + RC_LIFT_AT(pixel);
  __global const ushort* sun = sun_bits + RC_SUN_AT(pixel);
  __global const float* blocked = sky_blocked + RC_SKY_AT(pixel);

  __global ulong* keys = row_keys + (size_t)item * capacity;
  __global float* sums = row_sums + RC_SUMS_AT(item, capacity);
  __global float* path = path_sums + RC_PATH_AT(item);
  __global float* truth_row = truth + RC_TRUTH_AT(item);

  uint count = 0;
  if (fresh) {
    for (int i = 0; i < RC_HEIGHTS * RC_CARRIED(RC_CHUNKED); ++i) path[i] = 0.0f;
    for (int i = 0; i < RC_TRUTH_SUMS * RC_CARRIED(RC_CHUNKED); ++i) truth_row[i] = 0.0f;
  } else {
    count = row_count[item];
    if (count == RC_ROW_OVERFLOW) return;
  }

  /* Per-sample scalars: sun, then each component; all will carry the sample weight. */
  float value[RC_LIT][RC_PADDED_SAMPLES];
  float height_fraction[RC_PADDED_SAMPLES];
  uint height_index[RC_PADDED_SAMPLES];
  uint surface_id[RC_PADDED_SAMPLES];

  const RayGroup rays = groups[rc_group_of(pixel, columns, RC_PIXELS_PER_GROUP)];
  const float4 sensor = fma((float4)(-rays.d0.w), rays.d0, rays.origin); /* of a moving pose: at the pixel's middle */

#if SOLAR_COMPONENTS > 0
  float last_x = 2.0f, last_y = 2.0f, last_z = 2.0f;
  float4 unoccluded = (float4)(0.0f);
#endif
  for (int s = 0; s < RC_PADDED_SAMPLES; ++s) {
    uint id = RC_NONE;
    int h = 0;
    float f = 0.0f;
    for (int m = 0; m < RC_LIT; ++m) value[m][s] = 0.0f;
    if (s < RC_CHUNK_SAMPLES && hit_instance[s] != RC_NONE) {
      const uint primitive = hit_primitive[s];
      id = rc_block(scene, primitive / RC_BLOCK)->surface[primitive % RC_BLOCK];
      rc_node_weights(point[RC_PLANE(RC_POINT_Z) + s], height_first, height_step, RC_HEIGHTS, &h, &f);
#if SOLAR_COMPONENTS > 0
      const float nx = point[RC_PLANE(RC_NORMAL_X) + s], ny = point[RC_PLANE(RC_NORMAL_Y) + s],
                  nz = point[RC_PLANE(RC_NORMAL_Z) + s];
      if (nx != last_x || ny != last_y || nz != last_z) {
        int node[3];
        float share[3];
        rc_octahedral_nodes(nx, ny, nz, (int)map_size, node, share);
        unoccluded = fma((float4)(share[0]), irradiance_map[node[0]],
                         fma((float4)(share[1]), irradiance_map[node[1]], share[2] * irradiance_map[node[2]]));
        last_x = nx;
        last_y = ny;
        last_z = nz;
      }
      value[RC_SUN][s] = unoccluded.x;
#if SOLAR_COMPONENTS > 1
      value[RC_SUN + 1][s] = unoccluded.y;
#endif
#if SOLAR_COMPONENTS > 2
      value[RC_SUN + 2][s] = unoccluded.z;
#endif
#if SOLAR_COMPONENTS > 3
      value[RC_SUN + 3][s] = unoccluded.w;
#endif
#endif
#if RC_THERMAL_COMPONENTS > 0
      int tilt;
      float beyond;
      rc_node_weights(point[RC_PLANE(RC_NORMAL_Z) + s], -1.0f, 2.0f / (RC_TILT_NODES - 1), RC_TILT_NODES, &tilt,
                      &beyond);
      const float4 open = fma((float4)(1.0f - beyond), tilt_irradiance[tilt], beyond * tilt_irradiance[tilt + 1]);
      value[RC_SUN + SOLAR_COMPONENTS][s] = open.x;
#if RC_THERMAL_COMPONENTS > 1
      value[RC_SUN + SOLAR_COMPONENTS + 1][s] = open.y;
#endif
#if RC_THERMAL_COMPONENTS > 2
      value[RC_SUN + SOLAR_COMPONENTS + 2][s] = open.z;
#endif
#endif
    }
    surface_id[s] = id;
    height_index[s] = (uint)h;
    height_fraction[s] = f;
  }

  /* Vector part: sun cosine, blocked sky, weights, path and truth sums. */
  float16 t_hit = 0.0f, t_sun = 0.0f, t_x = 0.0f, t_y = 0.0f, t_z = 0.0f, t_range = 0.0f, t_cos = 0.0f;
  float16 p_sum[RC_HEIGHTS];
  for (int h = 0; h < RC_HEIGHTS; ++h) p_sum[h] = 0.0f;
  const uint16 lane = (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (int g = 0; g < RC_WORDS; ++g) {
    const int16 hit = rc_load16(g, surface_id) != (uint16)(RC_NONE);
    const float16 weight = rc_load16(g, chunk_weight);
    const float16 px = rc_load16(g, point + RC_PLANE(RC_POINT_X)), py = rc_load16(g, point + RC_PLANE(RC_POINT_Y)),
                  pz = rc_load16(g, point + RC_PLANE(RC_POINT_Z));
    const float16 nx = rc_load16(g, point + RC_PLANE(RC_NORMAL_X)), ny = rc_load16(g, point + RC_PLANE(RC_NORMAL_Y));
    const float16 nz = rc_load16(g, point + RC_PLANE(RC_NORMAL_Z));
    const float16 cosine =
        fma(nx, (float16)(sun_direction.x), fma(ny, (float16)(sun_direction.y), nz * sun_direction.z));
    const int16 lit = hit & (((((uint16)((uint)sun[g])) >> lane) & 1u) != 0u);
    const float16 w_hit = masked(weight, hit);
#if RC_SUN
    rc_store16(masked(weight * fmax(cosine, (float16)(0.0f)), lit), g, value[0]);
#endif
    for (int m = 0; m < RC_COMPONENTS; ++m) {
      const float16 e = rc_load16(g, value[RC_SUN + m]) - rc_load16(g, blocked + RC_PLANE(m));
      rc_store16(masked(weight * e, hit), g, value[RC_SUN + m]);
    }
    /* Truth is of the surface itself, not of where its shadow rays start. */
    const float16 reach = rc_load16(g, lift);
    const float16 x = rc_step_back(px, nx, reach), y = rc_step_back(py, ny, reach), z = rc_step_back(pz, nz, reach);
    const float16 rx = x - sensor.x, ry = y - sensor.y, rz = z - sensor.z;
    const float16 range = sqrt(fma(rx, rx, fma(ry, ry, rz * rz)));
    t_hit += w_hit;
    t_sun += masked(weight, lit);
    t_x += masked(w_hit * x, hit);
    t_y += masked(w_hit * y, hit);
    t_z += masked(w_hit * z, hit);
    t_range += masked(w_hit * range, hit);
    t_cos += masked(w_hit * cosine, hit);
#if RC_HEIGHTS == 1
    p_sum[0] += weight;
#else
    const uint16 hi = rc_load16(g, height_index);
    const float16 hf = rc_load16(g, height_fraction);
    for (uint h = 0; h < RC_HEIGHTS; ++h)
      p_sum[h] += masked(weight * (1.0f - hf), hi == (uint16)(h)) + masked(weight * hf, hi + 1u == (uint16)(h));
#endif
  }
  for (int h = 0; h < RC_HEIGHTS; ++h) ADD(path, h, RC_HEIGHTS, lane_sum(p_sum[h]) / sample_total);
  ADD(truth_row, RC_TRUTH_HIT, RC_TRUTH_SUMS, lane_sum(t_hit) / sample_total);
  ADD(truth_row, RC_TRUTH_SUN, RC_TRUTH_SUMS, lane_sum(t_sun) / sample_total);
  ADD(truth_row, RC_TRUTH_X, RC_TRUTH_SUMS, lane_sum(t_x) / sample_total);
  ADD(truth_row, RC_TRUTH_Y, RC_TRUTH_SUMS, lane_sum(t_y) / sample_total);
  ADD(truth_row, RC_TRUTH_Z, RC_TRUTH_SUMS, lane_sum(t_z) / sample_total);
  ADD(truth_row, RC_TRUTH_RANGE, RC_TRUTH_SUMS, lane_sum(t_range) / sample_total);
  ADD(truth_row, RC_TRUTH_INCIDENCE, RC_TRUTH_SUMS, lane_sum(t_cos) / sample_total);

  /* One surface at a time, in the order of its first sample. */
  for (int s = 0; s < RC_CHUNK_SAMPLES; ++s) {
    const uint id = surface_id[s];
    if (id == RC_NONE) continue;
    float16 sum[RC_LIT * RC_HEIGHTS + 1];
    for (int i = 0; i <= RC_LIT * RC_HEIGHTS; ++i) sum[i] = 0.0f;
#if RC_TEMPERATURES > 0 && RC_HEIGHTS > 1
    float16 covered[RC_HEIGHTS];
    for (int h = 0; h < RC_HEIGHTS; ++h) covered[h] = 0.0f;
#endif
    for (int g = s / 16; g < RC_WORDS; ++g) {
      const uint16 ids = rc_load16(g, surface_id);
      const int16 mine = ids == (uint16)(id);
      sum[RC_LIT * RC_HEIGHTS] += masked(rc_load16(g, chunk_weight), mine);
#if RC_HEIGHTS == 1
      for (int m = 0; m < RC_LIT; ++m) sum[m] += masked(rc_load16(g, value[m]), mine);
#else
      const uint16 hi = rc_load16(g, height_index);
      const float16 hf = rc_load16(g, height_fraction);
      for (uint h = 0; h < RC_HEIGHTS; ++h) {
        const float16 part =
            masked(1.0f - hf, mine & (hi == (uint16)(h))) + masked(hf, mine & (hi + 1u == (uint16)(h)));
        for (int m = 0; m < RC_LIT; ++m)
          sum[m * RC_HEIGHTS + h] = fma(rc_load16(g, value[m]), part, sum[m * RC_HEIGHTS + h]);
#if RC_TEMPERATURES > 0
        covered[h] = fma(rc_load16(g, chunk_weight), part, covered[h]);
#endif
      }
#endif
      rc_store16(select(ids, (uint16)(RC_NONE), as_uint16(mine)), g, surface_id);
    }
    float total[RC_LIT * RC_HEIGHTS + 1];
    for (int i = 0; i <= RC_LIT * RC_HEIGHTS; ++i) total[i] = lane_sum(sum[i]) / sample_total;
    const float* cover = total + RC_LIT * RC_HEIGHTS;
#if RC_TEMPERATURES > 0 && RC_HEIGHTS > 1
    float cover_of[RC_HEIGHTS];
    for (int h = 0; h < RC_HEIGHTS; ++h) cover_of[h] = lane_sum(covered[h]) / sample_total;
    cover = cover_of;
#endif
    if (!deposit(keys, sums, &count, capacity, rc_surface(scene, id), total, cover, surface_nodes + 4 * (size_t)id)) {
      count = RC_ROW_OVERFLOW;
      break;
    }
  }
  row_count[item] = count;
}

kernel void shade(SHADE_PARAMETERS) {
  shade_body((uint)get_global_id(0), pixel_count, pixel_list, use_list, capacity, fresh, groups, columns, hits,
             surface_points, lifts, sun_bits, sky_blocked, RC_PASS_BLOCKS, RC_PASS_SURFACES, chunk_weight, sample_total,
             sun_direction, irradiance_map, map_size, tilt_irradiance, surface_nodes, height_first, height_step,
             row_count, row_keys, row_sums, path_sums, truth);
}
