/* Arguments of a camera's kernels (arguments.h). Buffers by pixel and by item: tile_layout.h. */
#ifndef RAYCUBE_KERNELS_SHARED_CAMERA_ARGUMENTS_H
#define RAYCUBE_KERNELS_SHARED_CAMERA_ARGUMENTS_H

#include "kernels/shared/arguments.h"

/* clang-format off */
/* How a pixel's samples lie: kernels/sampling/sampler.h. */
#define RC_SAMPLING_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(rc_uint, sampler) NEXT()      /* RC_SAMPLER_* */ \
  VALUE(rc_uint, samples_u) NEXT()    /* along the line */ \
  VALUE(rc_uint, samples_v) NEXT()    /* across it */ \
  VALUE(rc_float, sample_support)     /* width of the square that they cover, pixels */

#define RC_TRACE_PRIMARY_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(RayGroup, groups) NEXT() \
  WRITE(rc_uint, hits) NEXT() \
  RC_SAMPLING_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_uint, seed) NEXT()         /* low 32 bits of Simulation::seed */ \
  VALUE(rc_uint, columns) NEXT()      /* pixels of a line of the tile */ \
  VALUE(rc_uint, first_sample) NEXT() \
  VALUE(rc_uint, sample_count)

#define RC_MAKE_SURFACE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(Lobe, lobes) NEXT()            /* [surface][RC_LOBE_STRIDE], read where RC_SHAPED or RC_THROUGH */ \
  READ(RayGroup, groups) NEXT() \
  READ(rc_uint, hits) NEXT() \
  WRITE(rc_float, surface) NEXT() \
  WRITE(rc_float, lift) NEXT() \
  RC_SAMPLING_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_uint, seed) NEXT() \
  VALUE(rc_uint, columns) NEXT() \
  VALUE(rc_uint, first_sample) NEXT() \
  VALUE(rc_uint, sample_count)

/* kernels/geometry/skyline.h; the grid's corner and cells a metre: x, y, z of skyline_frame. */
#define RC_SKYLINE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  READ(rc_float, skyline_cells) NEXT() /* [row][column][2]: top, skyline (scene_compiler/skyline.h) */ \
  VALUE(rc_float4, skyline_frame) NEXT() \
  VALUE(rc_uint, skyline_instance) NEXT() \
  VALUE(rc_uint, skyline_columns) NEXT() \
  VALUE(rc_uint, skyline_rows)

#define RC_TRACE_SUN_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(RayGroup, groups) NEXT() \
  READ(rc_uint, hits) NEXT() \
  READ(rc_float, surface) NEXT() \
  RC_SKYLINE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_float4, direction) NEXT()  /* to the sun, unit, w = 0 */ \
  WRITE(rc_ushort, sun) NEXT() \
  VALUE(rc_uint, columns)

/* kernels/light/sky_map.h */
#define RC_SKY_MAP_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  READ(rc_float4, sky_map) NEXT() \
  READ(rc_float, sky_zenith) NEXT() \
  READ(rc_float, sky_azimuth) NEXT() \
  VALUE(rc_uint, zeniths) NEXT() \
  VALUE(rc_uint, azimuths) NEXT() \
  READ(rc_float4, thermal_map) NEXT() \
  READ(rc_float, thermal_zenith) NEXT() \
  VALUE(rc_uint, thermal_zeniths) NEXT() \
  VALUE(rc_float4, sun_azimuth)

#define RC_TRACE_SKY_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(Lobe, lobes) NEXT()            /* [surface][RC_LOBE_STRIDE], read where RC_SHAPED */ \
  READ(RayGroup, groups) NEXT() \
  READ(rc_uint, hits) NEXT() \
  READ(rc_float, surface) NEXT() \
  RC_SKYLINE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  READ(rc_float, open_share) NEXT()   /* [surface]: of the open sky, taken for granted, 0 .. 1 */ \
  RC_SKY_MAP_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_float4, density) NEXT()    /* x cosine, y sun, z g of SkyDensity */ \
  VALUE(rc_float4, sun_direction) NEXT() \
  VALUE(rc_uint, rays) NEXT()         /* of a pixel */ \
  RC_SAMPLING_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_uint, seed) NEXT() \
  VALUE(rc_uint, columns) NEXT() \
  VALUE(rc_uint, first_sample) NEXT() \
  VALUE(rc_uint, sample_count) NEXT() \
  WRITE(rc_float, met_sky)

#define RC_TRACE_LAMPS_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(Lobe, lobes) NEXT()            /* [surface][RC_LOBE_STRIDE], read where RC_SHAPED */ \
  READ(RayGroup, groups) NEXT() \
  READ(rc_uint, hits) NEXT() \
  READ(rc_float, surface) NEXT() \
  READ(rc_float, lift) NEXT() \
  READ(Lamp, lamps) NEXT()            /* by source */ \
  READ(rc_uint, lamp_first) NEXT()    /* of each source, and the end */ \
  READ(rc_float, lamp_distribution) NEXT() /* of each lamp: vertical angles, horizontal angles, values by both */ \
  RC_SAMPLING_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_uint, seed) NEXT() \
  VALUE(rc_uint, columns) NEXT() \
  VALUE(rc_uint, first_sample) NEXT() \
  WRITE(rc_float, met_sky)

#define RC_TRACE_BOUNCE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  SCENE(Surface, surfaces, SURFACES) NEXT() \
  READ(Lobe, lobes) NEXT()            /* [surface][RC_LOBE_STRIDE], read where RC_SHAPED or RC_THROUGH */ \
  READ(rc_float4, scattering) NEXT()  /* [surface]: x chance of the near side, y largest R + T, z of gloss */ \
  READ(rc_float, skeleton_curve) NEXT() /* [curve - 1][skeleton] */ \
  READ(rc_uint, albedo_at) NEXT()     /* read where lobe_albedo, as the next: kernels/light/lobe_albedo.h */ \
  READ(rc_float, albedo) NEXT() \
  READ(rc_float, source_share) NEXT() /* [sun, components][skeleton]: a source's light over that of all */ \
  READ(rc_float, ground_around) NEXT() /* [skeleton]: pi times its radiance over the light of all */ \
  READ(Lamp, lamps) NEXT()            /* read where there are any, as the next */ \
  READ(rc_uint, lamp_first) NEXT() \
  READ(rc_float, lamp_distribution) NEXT() \
  VALUE(rc_float, lowest) NEXT()      /* z of the scene, m: from below nothing sees the ground around */ \
  READ(RayGroup, groups) NEXT() \
  READ(rc_uint, hits) NEXT() \
  READ(rc_float, surface) NEXT() \
  READ(rc_float, lift) NEXT()         /* read where RC_PLATES, as the next */ \
  READ(rc_ushort, sun) NEXT() \
  RC_SKYLINE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  RC_SKY_MAP_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_float4, sun_direction) NEXT() \
  VALUE(rc_uint, sun_up) NEXT() \
  READ(rc_float, chunk_weight) NEXT() \
  VALUE(rc_float, sample_total) NEXT() /* samples of a pixel, all chunks */ \
  VALUE(rc_uint, paths) NEXT()        /* of a pixel */ \
  VALUE(rc_uint, levels) NEXT()       /* surfaces after the first; 0: no path is followed */ \
  RC_SAMPLING_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_uint, seed) NEXT() \
  VALUE(rc_uint, columns) NEXT() \
  VALUE(rc_uint, first_sample) NEXT() \
  VALUE(rc_uint, sample_count) NEXT() \
  WRITE(rc_float, glow) NEXT() \
  VALUE(rc_uint, log_paths) NEXT()    /* of a pixel, as they are numbered; 0: no step is handed over */ \
  WRITE(PathStep, path_log)           /* [pixel][log_paths][levels + 1] */

#define RC_FIRST_OPAQUE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(Lobe, lobes) NEXT()            /* [surface][RC_LOBE_STRIDE] */ \
  READ(RayGroup, groups) NEXT() \
  READ(rc_uint, hits) NEXT() \
  RC_SAMPLING_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  VALUE(rc_uint, seed) NEXT() \
  VALUE(rc_uint, columns) NEXT() \
  VALUE(rc_uint, first_sample) NEXT() \
  WRITE(rc_uint, opaque)

#define RC_SHADE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  VALUE(rc_uint, item_count) NEXT() \
  READ(rc_uint, pixel_list) NEXT()    /* [item]: pixel of the tile, where use_list; else they are the same */ \
  VALUE(rc_uint, use_list) NEXT() \
  VALUE(rc_uint, capacity) NEXT()     /* keys that a row holds */ \
  VALUE(rc_uint, fresh) NEXT()        /* 1: rows start empty; 0: they go on */ \
  READ(RayGroup, groups) NEXT() \
  VALUE(rc_uint, columns) NEXT() \
  READ(rc_uint, hits) NEXT() \
  READ(rc_float, surface) NEXT() \
  READ(rc_float, lift) NEXT() \
  READ(rc_ushort, sun) NEXT() \
  READ(rc_float, met_sky) NEXT() \
  READ(rc_float, open_share) NEXT()   /* [surface], as trace_sky had it */ \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Surface, surfaces, SURFACES) NEXT() \
  READ(Lobe, lobes) NEXT()            /* [surface][RC_LOBE_STRIDE], read where RC_SHAPED */ \
  READ(rc_float, chunk_weight) NEXT() \
  VALUE(rc_float, sample_total) NEXT() /* samples of a pixel, all chunks */ \
  VALUE(rc_float4, sun_direction) NEXT() \
  READ(rc_float4, irradiance_map) NEXT() /* [map_size][map_size], kernels/atmosphere/nodes.h */ \
  VALUE(rc_uint, map_size) NEXT() \
  READ(rc_float4, tilt_irradiance) NEXT() /* [RC_TILT_NODES] */ \
  READ(rc_float4, surface_node) NEXT() /* [surface]: its materials' temperatures on their axis */ \
  READ(rc_uint, albedo_at) NEXT()     /* read where lobe_albedo, as the next: kernels/light/lobe_albedo.h */ \
  READ(rc_float, albedo) NEXT() \
  VALUE(rc_float, height_first) NEXT() \
  VALUE(rc_float, height_step) NEXT() \
  WRITE(rc_uint, row_count) NEXT() \
  WRITE(rc_ulong, row_keys) NEXT() \
  WRITE(rc_float, row_sums) NEXT() \
  WRITE(rc_float, path_sums) NEXT() \
  WRITE(rc_float, truth)

#define RC_RESOLVE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(TileShape, tile) NEXT() \
  VALUE(rc_uint, first_item) NEXT() \
  VALUE(rc_uint, item_count) NEXT() \
  READ(rc_uint, pixel_list) NEXT() \
  VALUE(rc_uint, use_list) NEXT() \
  VALUE(rc_uint, capacity) NEXT() \
  VALUE(rc_uint, term_capacity) NEXT() \
  READ(RayGroup, groups) NEXT() \
  VALUE(rc_uint, columns) NEXT() \
  READ(rc_uint, row_count) NEXT() \
  READ(rc_ulong, row_keys) NEXT() \
  READ(rc_float, row_sums) NEXT() \
  READ(rc_float, path_sums) NEXT() \
  READ(rc_ulong, baked_keys) NEXT()   /* of the band table, ascending */ \
  READ(rc_uint, baked_rows) NEXT()    /* of each of them */ \
  VALUE(rc_uint, baked_count) NEXT() \
  VALUE(rc_float, view_first) NEXT() \
  VALUE(rc_float, view_step) NEXT() \
  VALUE(rc_float, path_x_first) NEXT() \
  VALUE(rc_float, path_x_step) NEXT() \
  VALUE(rc_float, path_y_first) NEXT() \
  VALUE(rc_float, path_y_step) NEXT() \
  VALUE(rc_uint, environment_nodes) NEXT() /* RC_ENVIRONMENT_NODES; 0: no light of the ground around joins */ \
  READ(rc_uint, environment_row) NEXT() /* [item][RC_ENVIRONMENT_NODES], as the next */ \
  READ(rc_float, environment_weight) NEXT() \
  READ(rc_float, glow) NEXT() \
  VALUE(rc_uint, glow_part) NEXT()    /* part of the samples that is asked for; RC_PATH_PARTS: all */ \
  VALUE(rc_float, glow_scale) NEXT()  /* weight of all samples over that of the part */ \
  VALUE(rc_float, glow_spread) NEXT() /* what a part's distance from the whole is multiplied by */ \
  VALUE(rc_uint, skeleton_row) NEXT() /* of the band table, of the first skeleton wavelength; the others follow */ \
  VALUE(rc_uint, skeleton_rows) NEXT() /* wavelengths; for each source of lamps so many again */ \
  WRITE(rc_uint, term_count) NEXT() \
  WRITE(rc_uint, term_row) NEXT()     /* [item][term_capacity], as the next */ \
  WRITE(rc_float, term_weight)

#define RC_INTEGRATE_BANDS_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  VALUE(rc_uint, first_item) NEXT() \
  VALUE(rc_uint, item_count) NEXT() \
  READ(rc_uint, pixel_list) NEXT() \
  VALUE(rc_uint, use_list) NEXT() \
  VALUE(rc_uint, term_capacity) NEXT() \
  READ(rc_uint, term_count) NEXT() \
  READ(rc_uint, term_row) NEXT() \
  READ(rc_float, term_weight) NEXT() \
  VALUE(rc_uint, words) NEXT()        /* of 16 bands, the last one padded */ \
  READ(rc_float, table) NEXT()        /* [row][channels][words][16] */ \
  WRITE(rc_float, radiance)         /* [pixel][words][16] */
/* clang-format on */

#endif
