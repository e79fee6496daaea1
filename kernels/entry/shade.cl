/* shade: from hits, surface points, sun visibility and blocked sky to per-pixel rows of (product key, scalar sums).
 * Reads:  hits, surface and lift, sun bits, met sky of the tile (or of one chunk of its samples).
 * Writes: row count, keys, sums, path sums, truth sums. Next: resolve.
 * One work-item per pixel, any local size. Sums are masked float16 sums over sample groups in sample order, then one
 * fixed lane tree, so that row capacity, tile and work-group cannot change a bit. Sample weights come relative to their
 * mean, 1 for the plain box, so that a chunk's counts are exact; their number divides the chunk's sums. */
#pragma OPENCL FP_CONTRACT OFF
#include "kernels/shading/sample_light.h"
#include "kernels/shading/seen_light.h"
#include "kernels/shading/truth_sums.h"
#include "kernels/shading/surfaces.h"
#include "kernels/shared/camera_arguments.h"

RC_BODY shade_body(uint item, RC_PARAMETERS(RC_SHADE_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_SURFACES(scene);
  if (item >= item_count) return;
  if (!fresh && row_count[item] == RC_ROW_OVERFLOW) return;
  const uint pixel = use_list ? pixel_list[item] : item; /* index in the tile's inputs; outputs go by item */
  const TracedPixel traced = {hits + RC_HITS_AT(pixel),
                              hits + RC_HITS_AT(pixel) + RC_HIT_PLANE(RC_HIT_PRIMITIVE),
                              surface + RC_SURFACE_AT(pixel),
                              lift + RC_LIFT_AT(pixel),
                              sun + RC_SUN_AT(pixel),
                              met_sky + RC_MET_SKY_AT(pixel),
                              chunk_weight};
  PixelRow row =
      rc_open_row(fresh, row_count[item], capacity, row_keys + (size_t)item * capacity,
                  row_sums + RC_SUMS_AT(item, capacity), path_sums + RC_PATH_AT(item), truth + RC_TRUTH_AT(item));
  const RayGroup rays = groups[rc_group_of(pixel, columns, RC_PIXELS_PER_GROUP)];
  const float4 sensor = fma((float4)(-rays.d0.w), rays.d0, rays.origin); /* of a moving pose: at the pixel's middle */

  const OpenSky sky = {irradiance_map, (int)map_size, tilt_irradiance, open_share RC_GATHER_ALBEDOS()};
  ShadedSamples samples;
  rc_light_of_samples(scene, &traced, lobes, &sky, height_first, height_step, &samples);
  TruthSums sums;
  rc_clear_truth(&sums);
  for (int g = 0; g < RC_WORDS; ++g) {
    const ShadedWord word = rc_shaded_word(&traced, &samples, sun_direction, g);
    rc_weigh_seen_light(&traced, lobes, &word, sun_direction, g, &samples);
    if (g >= RC_NEAR_WORDS) continue; /* truth and path are of what is seen */
    rc_add_truth(&traced, &word, sensor, g, &sums);
    rc_add_path(&word, &samples, g, &sums);
  }
  rc_close_truth(&sums, sample_total, &row);
  rc_deposit_surfaces(scene, &traced, surface_node, sample_total, &samples, &row);
  row_count[item] = row.count;
}

kernel void shade(RC_PARAMETERS(RC_SHADE_ARGUMENTS)) {
  shade_body((uint)get_global_id(0), RC_PASSED(RC_SHADE_ARGUMENTS));
}
