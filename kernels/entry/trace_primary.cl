/* Reads: ray groups and the scene. Writes: instance and primitive of every sample's closest hit. Next: make_surface. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/bundle_primary.h"
#include "kernels/geometry/ray_trace.h"
#include "kernels/shared/camera_arguments.h"

/* Ray by ray. */
static inline void rc_primary_alone(SceneArrays scene, const TileShape* tile, RayGroup group, GroupPlace place,
                                    Sampling sampling, uint seed, uint first_sample, uint sample_count,
                                    global uint* hits) {
  for (uint p = 0; p < place.used; ++p) {
    global uint* out = hits + rc_hits_at(tile, place.pixel + p);
    for (uint k = 0; k < tile->near; ++k) {
      Hit hit;
      hit.instance = hit.primitive = RC_NONE;
      if (k < sample_count) {
        float a, b;
        rc_group_sample(sampling, seed, place.number + p, p, first_sample + k, &a, &b);
        hit = rc_trace_from(scene, group.origin, rc_group_offset(group, a, b), rc_group_direction(group, a, b));
      }
      out[rc_hits_slot(k)] = hit.instance;
      out[rc_hits_slot(k) + RC_PLANE(RC_HIT_PRIMITIVE)] = hit.primitive;
    }
  }
}

/* All rays of the group together. false: that costs more than one by one, and nothing is written. */
static inline bool rc_primary_together(SceneArrays scene, const TileShape* tile, RayGroup group, GroupPlace place,
                                       Sampling sampling, uint seed, uint first_sample, uint sample_count,
                                       global uint* hits) {
  Closest closest;
  GroupFrame frame;
  frame.rays = group;
  frame.half_a = 0.5f * (float)(tile->pixels_per_group - 1u) + 0.5f * sampling.support;
  frame.half_b = 0.5f * sampling.support;
#if RC_GRID
  rc_set_grid(&frame, sampling, tile->pixels_per_group, place.used, first_sample, sample_count);
  const uint words = rc_grid_slots(&frame) / 16u;
#else
  Scatter samples;
  const uint near_words = rc_near_words(tile), words = place.used * near_words;
  rc_scatter_samples(&samples, sampling, tile->near, seed, place, first_sample, sample_count);
  frame.samples = &samples;
  frame.words = words;
#endif
  for (uint word = 0; word < words; ++word) rc_store16((float16)(0.0f), word, closest.near);
  const uint budget = min(tile->most_visits, RC_PRIMARY_BUDGET(place.used * sample_count));
  if (!rc_primary_group(scene, &frame, budget, &closest)) return false;
#if RC_GRID
  global uint* out = hits + rc_hits_at(tile, place.pixel);
  rc_write_pixels(&frame, closest.near, closest.instance, tile->near, place.used, out, rc_hits_at(tile, 1u));
  rc_write_pixels(&frame, closest.near, closest.primitive, tile->near, place.used, out + RC_PLANE(RC_HIT_PRIMITIVE),
                  rc_hits_at(tile, 1u));
#else
  for (uint p = 0; p < place.used; ++p) {
    global uint* out = hits + rc_hits_at(tile, place.pixel + p);
    for (uint word = 0; word < near_words; ++word, out += RC_HIT_WORD) {
      const uint from = p * near_words + word;
      const int16 none = rc_load16(from, closest.near) == 0.0f;
      rc_store16(select(rc_load16(from, closest.instance), (uint16)(RC_NONE), none), 0, out);
      rc_store16(select(rc_load16(from, closest.primitive), (uint16)(RC_NONE), none), 0,
                 out + RC_PLANE(RC_HIT_PRIMITIVE));
    }
  }
#endif
  return true;
}

RC_BODY trace_primary_body(uint index, RC_PARAMETERS(RC_TRACE_PRIMARY_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  const RayGroup group = rc_group_rays(groups, index);
  const Sampling sampling = RC_GATHER_SAMPLING();
  if (tile.most_visits &&
      rc_primary_together(scene, &tile, group, place, sampling, seed, first_sample, sample_count, hits))
    return;
  rc_primary_alone(scene, &tile, group, place, sampling, seed, first_sample, sample_count, hits);
}

kernel void trace_primary(RC_PARAMETERS(RC_TRACE_PRIMARY_ARGUMENTS)) {
  trace_primary_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_PRIMARY_ARGUMENTS));
}
