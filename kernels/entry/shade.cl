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
  const TracedPixel traced = {hits + rc_hits_at(&tile, pixel),       surface + rc_surface_at(&tile, pixel),
                              lift + rc_lift_at(&tile, pixel),       sun + rc_sun_at(&tile, pixel),
                              met_sky + rc_met_sky_at(&tile, pixel), chunk_weight};
  PixelRow row = rc_open_row(&tile, fresh, row_count[item], capacity, row_keys + (size_t)item * capacity,
                             row_sums + rc_sums_at(&tile, item, capacity), path_sums + rc_path_at(&tile, item),
                             truth + rc_truth_at(&tile, item));
  const RayGroup rays = groups[rc_group_of(pixel, columns, tile.pixels_per_group)];
  const float4 sensor = fma((float4)(-rays.d0.w), rays.d0, rays.origin); /* of a moving pose: at the pixel's middle */

  const OpenSky sky = {irradiance_map, (int)map_size, tilt_irradiance, open_share RC_GATHER_ALBEDOS()};
  ShadedSamples samples;
  rc_light_of_samples(scene, &tile, &traced, lobes, &sky, height_first, height_step, &samples);
  TruthSums sums;
  rc_clear_truth(&sums);
  for (uint g = 0; g < tile.words; ++g) {
    const ShadedWord word = rc_shaded_word(&tile, &traced, &samples, sun_direction, g);
    rc_weigh_seen_light(&tile, &traced, lobes, &word, sun_direction, g, &samples);
    if (g < rc_near_words(&tile)) rc_add_truth(&traced, &word, sensor, g, &sums); /* of what is seen */
  }
  rc_add_paths(&tile, &traced, &samples, sample_total, &row);
  rc_close_truth(&tile, &sums, sample_total, &row);
  rc_deposit_surfaces(scene, &tile, &traced, surface_node, sample_total, &samples, &row);
  row_count[item] = row.count;
}

kernel void shade(RC_PARAMETERS(RC_SHADE_ARGUMENTS)) {
  shade_body((uint)get_global_id(0), RC_PASSED(RC_SHADE_ARGUMENTS));
}
