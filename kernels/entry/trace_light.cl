/* Reads: surface points of make_surface, the scene, directions to the sun or into the sky. Writes, for the sun: one bit
 * per sample, seen or not; for the sky: per sample and component the irradiance that the blocked ones of its directions
 * take away. Launched once for each, as one kernel: the walk through the scene is compiled once. Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/light_points.h"
#include "kernels/light/light_rays.h"
#include "kernels/shared/camera_arguments.h"

RC_BODY trace_light_body(uint index, RC_PARAMETERS(RC_TRACE_LIGHT_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(groups, index, columns);
  /* The next group's points come from memory while this one's rays are traced. */
  if (!sky)
    rc_prefetch(surface + RC_SURFACE_AT(place.pixel + place.used),
                RC_PIXELS_PER_GROUP * (uint)(RC_SURFACE_AT(1) * sizeof(float)));
  const uint sharing = sky ? 1u : place.used; /* pixels whose samples share a direction */
  for (uint p = 0; p < place.used; p += sharing) {
    const uint first = sky ? rc_hash(seed, place.number + p, 0u, 21u) % sets * count : 0u;
    global const float* in = surface + RC_SURFACE_AT(place.pixel + p);
    global ushort* seen = sun + RC_SUN_AT(place.pixel + p);
    global float* out = blocked + RC_BLOCKED_AT(place.pixel + p);
#if RC_BUNDLE
    Points points;
    SkyPart held;
    points.costly = 0;
    for (uint part = 0; part < share; ++part) {
      if (sky)
        rc_gather_part(in, seed, place.number + p, first_sample, part, share, &points, &held);
      else
        rc_gather_points(in, sharing, &points);
      for (uint j = 0; j < count / share; ++j) {
        const uint m = first + rc_sky_direction(part, j, share);
        const float4 direction = directions[m];
        for (uint word = 0; word < points.words; ++word)
          points.live[word] = rc_mask16((sky ? rc_part_cosines(direction, &held, word)
                                             : rc_cosines(direction, rc_surface_word(in, word))) > 0.0f);
        rc_shadow_points(scene, direction, &points);
        if (!sky) break;
        rc_hide_direction(&points, direction, weights + m * RC_SKY_QUADS, share, &held);
#if RC_SHAPED
        rc_turn_direction(&points, in, direction, weights + m * RC_SKY_QUADS, share, &held);
#endif
      }
      if (sky)
        rc_write_part(&held, out);
      else
        for (uint word = 0; word < points.words; ++word) seen[word] = (ushort)points.live[word];
    }
#else
    for (uint word = 0; word < sharing * RC_WORDS; ++word) {
      uint lit = 0;
      for (uint bit = 0; bit < RC_WORD; ++bit) {
        const uint slot = word * RC_WORD + bit,
                   part = rc_sky_part(seed, place.number + p, first_sample + RC_SAMPLE_OF(slot), share);
        float4 hidden[RC_SKY_QUADS];
        if (rc_light_of_sample(scene, rc_surface_word(in, word) + bit, directions + first,
                               weights + first * RC_SKY_QUADS, sky, count, share, part, hidden))
          lit |= 1u << bit;
        if (sky) rc_write_hidden(hidden, out + slot);
      }
      if (!sky) seen[word] = (ushort)lit;
    }
#endif
  }
}

kernel void trace_light(RC_PARAMETERS(RC_TRACE_LIGHT_ARGUMENTS)) {
  trace_light_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_LIGHT_ARGUMENTS));
}
