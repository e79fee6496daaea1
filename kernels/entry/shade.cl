/* shade: from hits, surface points, sun visibility and blocked sky to per-pixel rows of (product key, scalar sums).
 * Reads:  hits, surface and lift, sun bits, blocked sky of the tile (or of one chunk of its samples).
 * Writes: row count, keys, sums, path sums, truth sums. Next: resolve.
 * One work-item per pixel, any local size. Sums are masked float16 sums over sample groups in sample order, then one
 * fixed lane tree, so that row capacity, tile and work-group cannot change a bit. Sample weights come relative to their
 * mean, 1 for the plain box, so that a chunk's counts are exact; their number divides the chunk's sums. */
#pragma OPENCL FP_CONTRACT OFF
#include "kernels/shading/sample_light.h"
#include "kernels/shading/seen_light.h"
#include "kernels/shading/truth_sums.h"
#include "kernels/shading/surfaces.h"

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
  if (!fresh && row_count[item] == RC_ROW_OVERFLOW) return;
  const uint pixel = use_list ? pixel_list[item] : item; /* index in the tile's inputs; outputs go by item */
  const TracedPixel traced = {hits + RC_HITS_AT(pixel),
                              hits + RC_HITS_AT(pixel) + RC_PLANE(RC_HIT_PRIMITIVE),
                              surface_points + RC_SURFACE_AT(pixel),
                              lifts + RC_LIFT_AT(pixel),
                              sun_bits + RC_SUN_AT(pixel),
                              sky_blocked + RC_SKY_AT(pixel),
                              chunk_weight};
  PixelRow row =
      rc_open_row(fresh, row_count[item], capacity, row_keys + (size_t)item * capacity,
                  row_sums + RC_SUMS_AT(item, capacity), path_sums + RC_PATH_AT(item), truth + RC_TRUTH_AT(item));
  const RayGroup rays = groups[rc_group_of(pixel, columns, RC_PIXELS_PER_GROUP)];
  const float4 sensor = fma((float4)(-rays.d0.w), rays.d0, rays.origin); /* of a moving pose: at the pixel's middle */

  const OpenSky sky = {irradiance_map, (int)map_size, tilt_irradiance};
  ShadedSamples samples;
  rc_light_of_samples(scene, &traced, &sky, height_first, height_step, &samples);
  TruthSums sums;
  rc_clear_truth(&sums);
  for (int g = 0; g < RC_WORDS; ++g) {
    const ShadedWord word = rc_shaded_word(&traced, &samples, sun_direction, g);
    rc_weigh_seen_light(&traced, &word, g, &samples);
    rc_add_truth(&traced, &word, sensor, g, &sums);
    rc_add_path(&word, &samples, g, &sums);
  }
  rc_close_truth(&sums, sample_total, &row);
  rc_deposit_surfaces(scene, &traced, surface_nodes, sample_total, &samples, &row);
  row_count[item] = row.count;
}

kernel void shade(SHADE_PARAMETERS) {
  shade_body((uint)get_global_id(0), pixel_count, pixel_list, use_list, capacity, fresh, groups, columns, hits,
             surface_points, lifts, sun_bits, sky_blocked, RC_PASS_BLOCKS, RC_PASS_SURFACES, chunk_weight, sample_total,
             sun_direction, irradiance_map, map_size, tilt_irradiance, surface_nodes, height_first, height_step,
             row_count, row_keys, row_sums, path_sums, truth);
}
