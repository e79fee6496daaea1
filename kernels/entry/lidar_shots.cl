/* Reads: owners' records (kernels/lidar/layout.h), sub-rays, the scene, matter, air, pulse. Writes: rows of expected
 * photons of light scattered once and more, ledger, first hits. One work-item is one owner: a shot, or a pixel of a
 * shot; its rows are its own, so sums have one order whatever the launch. Next: lidar_air, then the host. */
#include "kernels/lidar/context.h"
#include "kernels/lidar/paths.h"
#if !RC_SINGLE
#include "kernels/geometry/bundle_primary.h"
#endif

/* A store to memory that is read much later. */
#if defined(__has_builtin)
#if __has_builtin(__builtin_nontemporal_store)
#define RC_STORE_ONCE(value, to) __builtin_nontemporal_store((value), (to))
#endif
#endif
#ifndef RC_STORE_ONCE
#define RC_STORE_ONCE(value, to) *(to) = (value)
#endif

#define LIDAR_SHOTS_PARAMETERS                                                                                      \
  RC_NODES, RC_BLOCKS, RC_INSTANCES, global const float4 *restrict shots, global const float *restrict samples,     \
      global const float *restrict exits, global const float4 *restrict optics, global const float *restrict gloss, \
      global const float *restrict photons, global const float *restrict node_weight,                               \
      global const uint *restrict first_node, global const float2 *restrict air, RC_VOLUME_PARAMETERS,              \
      global const float *restrict taps, global const float *restrict settings, global float *restrict first,       \
      global float *restrict multiple, global float *restrict stopped, global long *restrict ledger,                \
      global float *restrict sums, global uint *restrict counts, global uint *restrict first_hits, uint seed,       \
      int bins, int taps_used, int first_tap, int phases

RC_BODY lidar_shots_body(uint owner, LIDAR_SHOTS_PARAMETERS) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const uint row_floats = rc_row_floats((uint)bins);
  const LidarTables tables = {shots + (size_t)owner * RC_SHOT_FLOAT4S,
                              samples,
                              exits,
                              optics,
                              gloss,
                              photons,
                              node_weight,
                              first_node,
                              air,
                              volumes,
                              volume_values,
                              volume_depth,
                              taps,
                              settings,
                              seed,
                              row_floats,
                              bins,
                              taps_used,
                              first_tap,
                              phases};
  const LidarTables* t = &tables;
  LidarSums total;
  total.rays = 0;
  for (uint line = 0; line < RC_LASER_LINES; ++line) {
    for (uint i = 0; i < RC_SUM_COUNT; ++i) total.sum[line][i][0] = total.sum[line][i][1] = 0.0f;
    for (uint i = 0; i < RC_LEDGER_COUNT; ++i) total.ledger[line][i] = 0;
  }
  const size_t rows = (size_t)RC_OWN_PIXELS * RC_LASER_LINES;
#if RC_ROW_WINDOW
  /* Rows to come lie in no cache: whole lines go there once, past the caches, and nothing waits for what was there. */
  RC_LINE float window[RC_ROW_WINDOW];
 private
  float *own_first = window, *own_multiple = window;
#else
  global float* own_first = first + owner * rows * row_floats;
  global float* own_multiple = multiple + (RC_BOUNCES > 1 ? owner * rows * row_floats : 0);
#endif
  global float* own_stopped = stopped + (RC_STOPPED ? owner * rc_stopped_floats(row_floats) : 0);
  for (size_t i = 0; i < rows * row_floats; i += 16) {
    rc_store16((float16)(0.0f), 0, own_first + i);
    if (RC_BOUNCES > 1) rc_store16((float16)(0.0f), 0, own_multiple + i);
  }
  if (RC_STOPPED)
    for (size_t i = 0; i < (rc_stops_by_pixel(t) ? rc_stopped_floats(row_floats) : (size_t)RC_LASER_LINES * row_floats);
         i += 16)
      rc_store16((float16)(0.0f), 0, own_stopped + i);

  for (uint begin = 0; begin < RC_RAY_COUNT; begin += RC_CHUNK_SAMPLES) {
    const uint words = (min((uint)RC_CHUNK_SAMPLES, RC_RAY_COUNT - begin) + 15u) / 16u;
#if RC_SINGLE
    global const float* at = samples + begin * 2u;
    const float4 reference = t->shot[RC_SHOT_REFERENCE], axis = t->shot[RC_SHOT_AXIS], du = t->shot[RC_SHOT_DU],
                 dv = t->shot[RC_SHOT_DV], residual = t->shot[RC_SHOT_RESIDUAL];
    const float s = t->shot[RC_SHOT_START].w, back = reference.w;
#else
    global const Scatter* scatter = (global const Scatter*)samples + begin / RC_CHUNK_SAMPLES;
    Closest closest;
    for (uint k = 0; k < RC_SLOTS; k += 16u) rc_store16((float16)(0.0f), 0, closest.near + k);
    GroupFrame frame;
    frame.rays.origin = t->shot[RC_SHOT_START];
    frame.rays.d0 = t->shot[RC_SHOT_AXIS];
    frame.rays.du = t->shot[RC_SHOT_DU];
    frame.rays.dv = t->shot[RC_SHOT_DV];
    frame.rays.origin.w = frame.rays.d0.w = frame.rays.du.w = frame.rays.dv.w = 0.0f;
    frame.rays.ov = (float4)(0.0f);
    frame.samples = scatter;
    rc_primary_group(scene, &frame, &closest);
#endif
    for (uint word = 0; word < words; ++word) {
      const uint slot = word * 16u, ray = begin + slot;
#if RC_SINGLE
      Hits16 hits;
      const float16 a = rc_load16(2u * word, at), b = rc_load16(2u * word + 1u, at);
      RC_LINE float lane_a[16], lane_b[16];
      rc_store16(a, 0, lane_a);
      rc_store16(b, 0, lane_b);
      for (uint k = 0; k < 16u; ++k) {
        hits.instance[k] = RC_NONE;
        hits.primitive[k] = 0;
        if (!(lane_a[k] < INFINITY)) continue;
        const float4 tilt = fma((float4)(lane_a[k]), du, lane_b[k] * dv);
        float4 offset = residual;
#if RC_EXITS
        offset += fma((float4)(exits[ray + k]), t->shot[RC_SHOT_EXIT_U],
                      exits[(RC_RAY_COUNT + 15) / 16 * 16 + ray + k] * t->shot[RC_SHOT_EXIT_V]);
#endif
        const float4 direction = axis + tilt,
                     origin = reference + fma((float4)(-back), direction, fma((float4)(s), tilt, offset));
        const Hit hit = rc_trace_ray(scene, (float4)(origin.xyz, 0.0f), (float4)(direction.xyz, 0.0f), false);
        hits.instance[k] = hit.instance;
        if (hit.instance != RC_NONE) hits.primitive[k] = hit.primitive;
      }
      const uint16 instances = rc_load16(0, hits.instance), primitives = rc_load16(0, hits.primitive);
#else
      const float16 a = rc_load16(0, scatter->a + slot), b = rc_load16(0, scatter->b + slot);
      const int16 none = rc_load16(0, closest.near + slot) == 0.0f;
      const uint16 instances = select(rc_load16(0, closest.instance + slot), (uint16)(RC_NONE), none),
                   primitives = select(rc_load16(0, closest.primitive + slot), (uint16)(0u), none);
#endif
#if RC_HITS
      RC_LINE uint instance_of[16], primitive_of[16];
      rc_store16(instances, 0, instance_of);
      rc_store16(primitives, 0, primitive_of);
      for (uint k = 0; k < 16u; ++k) {
        global uint* to_hits = first_hits + 2u * ((size_t)owner * ((RC_RAY_COUNT + 15) / 16 * 16) + ray + k);
        to_hits[0] = instance_of[k];
        to_hits[1] = instance_of[k] == RC_NONE ? RC_NONE : primitive_of[k];
      }
#endif
      rc_follow_word(scene, t, a, b, ray, instances, primitives, own_first, own_multiple, own_stopped, &total);
    }
  }

  for (uint line = 0; line < RC_LASER_LINES; ++line) {
    for (uint pixel = 0; pixel < RC_OWN_PIXELS; ++pixel) {
      const size_t row = (size_t)(pixel * RC_LASER_LINES + line) * row_floats;
      rc_close_row(t, own_first + row, total.sum[line]);
      if (RC_BOUNCES > 1) rc_close_row(t, own_multiple + row, total.sum[line]);
    }
    const size_t at = (size_t)owner * RC_LASER_LINES + line;
    for (uint i = 0; i < RC_SUM_COUNT; ++i) {
      sums[2u * (at * RC_SUM_COUNT + i)] = total.sum[line][i][0];
      sums[2u * (at * RC_SUM_COUNT + i) + 1u] = total.sum[line][i][1];
    }
    for (uint i = 0; i < RC_LEDGER_COUNT; ++i) ledger[at * RC_LEDGER_COUNT + i] = total.ledger[line][i];
  }
#if RC_ROW_WINDOW
  global float16* to = (global float16*)(first + owner * rows * row_floats);
  for (size_t i = 0; i < rows * row_floats; i += 16) RC_STORE_ONCE(rc_load16(0, window + i), to + i / 16);
#endif
  counts[owner] = RC_RAY_COUNT + total.rays;
}

kernel void lidar_shots(LIDAR_SHOTS_PARAMETERS) {
  lidar_shots_body((uint)get_global_id(0), RC_PASS_NODES, RC_PASS_BLOCKS, RC_PASS_INSTANCES, shots, samples, exits,
                   optics, gloss, photons, node_weight, first_node, air, volumes, volume_values, volume_depth, taps,
                   settings, first, multiple, stopped, ledger, sums, counts, first_hits, seed, bins, taps_used,
                   first_tap, phases);
}
