/* Reads: hits, surface points of make_surface, the scene, the direction to the sun. Writes: one bit per sample, seen or
 * not. Next: trace_sky, shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/any_hit.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/sun_points.h"
#include "kernels/shared/camera_arguments.h"

/* Whether a word of a group's slots is of a further lobe, which sees the sun as its near side does; its word. */
static inline bool rc_word_of_further(uint word) {
  return RC_FURTHER > 0 && word % RC_WORDS >= RC_OWN_SIDES * RC_NEAR_WORDS;
}
static inline uint rc_word_of_near(uint word) { return word - word % RC_WORDS + word % RC_WORDS % RC_NEAR_WORDS; }

RC_BODY trace_sun_body(uint index, RC_PARAMETERS(RC_TRACE_SUN_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(groups, index, columns);
  /* The next group's points come from memory while this one's rays are traced. */
  rc_prefetch(surface + RC_SURFACE_AT(place.pixel + place.used),
              RC_PIXELS_PER_GROUP * (uint)(RC_SURFACE_AT(1) * sizeof(float)));
  global const float* in = surface + RC_SURFACE_AT(place.pixel);
  global ushort* seen = sun + RC_SUN_AT(place.pixel);
#if RC_BUNDLE
  Points points;
  points.costly = 0;
  rc_gather_points(in, place.used, &points);
  for (uint word = 0; word < points.words; ++word)
    points.live[word] =
        rc_word_of_further(word) ? 0u : rc_mask16(rc_cosines(direction, rc_surface_word(in, word)) > 0.0f);
  const Skyline skyline = RC_GATHER_SKYLINE();
  points.ground = rc_ground_passed(scene, &skyline, hits + RC_HITS_AT(place.pixel), direction, &points);
  rc_shadow_points(scene, direction, &points);
  for (uint word = 0; word < points.words; ++word)
    seen[word] = (ushort)points.live[rc_word_of_further(word) ? rc_word_of_near(word) : word];
#else
  for (uint word = 0; word < place.used * RC_WORDS; ++word) {
    if (rc_word_of_further(word)) { /* behind its near side's */
      seen[word] = seen[rc_word_of_near(word)];
      continue;
    }
    global const float* at = rc_surface_word(in, word);
    uint lit = rc_mask16(rc_cosines(direction, at) > 0.0f);
    for (uint left = lit; left; left &= left - 1u) {
      const uint k = rc_lowest(left);
      const float4 point =
          (float4)(at[RC_PLANE(RC_POINT_X) + k], at[RC_PLANE(RC_POINT_Y) + k], at[RC_PLANE(RC_POINT_Z) + k], 0.0f);
      if (rc_any_hit(scene, point, direction)) lit &= ~(1u << k);
    }
    seen[word] = (ushort)lit;
  }
#endif
}

kernel void trace_sun(RC_PARAMETERS(RC_TRACE_SUN_ARGUMENTS)) {
  trace_sun_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_SUN_ARGUMENTS));
}
