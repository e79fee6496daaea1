/* Reads: hits, surface points of make_surface, the scene, the direction to the sun. Writes: one bit per sample, seen or
 * not. Next: trace_sky, shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/sun_points.h"
#include "kernels/shared/camera_arguments.h"

/* Further lobes see the sun as their near sides do. seen: words of one pixel. */
static inline void rc_copy_to_further(const TileShape* tile, global ushort* seen) {
#if RC_FURTHER
  for (uint word = rc_own_words(tile); word < tile->words; ++word) seen[word] = seen[word % rc_near_words(tile)];
#endif
}

RC_BODY trace_sun_body(uint index, RC_PARAMETERS(RC_TRACE_SUN_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  /* The next group's points come from memory while this one's rays are traced. */
  rc_prefetch(surface + rc_surface_at(&tile, place.pixel + place.used),
              tile.pixels_per_group * (uint)(rc_surface_at(&tile, 1u) * sizeof(float)));
  global const float* in = surface + rc_surface_at(&tile, place.pixel);
  global ushort* seen = sun + rc_sun_at(&tile, place.pixel);
  const uint own_words = rc_own_words(&tile);
  Points points;
  points.costly = 0;
  rc_gather_points(&tile, in, place.used, &points);
  for (uint word = 0; word < points.words; ++word)
    points.live[word] = rc_mask16(rc_cosines(direction, rc_surface_word(&tile, in, word)) > 0.0f);
  const Skyline skyline = RC_GATHER_SKYLINE();
  points.ground = rc_ground_passed(scene, &tile, &skyline, hits + rc_hits_at(&tile, place.pixel), direction, &points);
  rc_shadow_points(scene, direction, &points);
  for (uint p = 0; p < place.used; ++p, seen += tile.words) {
    for (uint word = 0; word < own_words; ++word) seen[word] = (ushort)points.live[p * own_words + word];
    rc_copy_to_further(&tile, seen);
  }
}

kernel void trace_sun(RC_PARAMETERS(RC_TRACE_SUN_ARGUMENTS)) {
  trace_sun_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_SUN_ARGUMENTS));
}
