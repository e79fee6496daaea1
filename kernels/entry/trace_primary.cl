/* Reads: ray groups and the scene. Writes: instance and primitive of every sample's closest hit. Next: make_surface. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/bundle_primary.h"
#include "kernels/geometry/ray_trace.h"
#include "kernels/shared/camera_arguments.h"

/* Ray by ray. */
static inline void rc_primary_alone(SceneArrays scene, RayGroup group, GroupPlace place, Sampling sampling, uint seed,
                                    uint first_sample, uint sample_count, uint columns, global uint* hits) {
  for (uint p = 0; p < place.used; ++p) {
    global uint* out = hits + RC_HITS_AT(place.pixel + p);
    for (uint k = 0; k < RC_NEAR_SAMPLES; ++k) {
      Hit hit;
      hit.instance = hit.primitive = RC_NONE;
      if (k < sample_count) {
        float a, b;
        rc_group_sample(sampling, seed, place.number + p, p, first_sample + k, &a, &b);
        hit = rc_trace_from(scene, group.origin, rc_group_offset(group, a, b), rc_group_direction(group, a, b));
      }
      out[k] = hit.instance;
      out[RC_HIT_PLANE(RC_HIT_PRIMITIVE) + k] = hit.primitive;
    }
  }
}

RC_BODY trace_primary_body(uint index, RC_PARAMETERS(RC_TRACE_PRIMARY_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(groups, index, columns);
  const RayGroup group = rc_group_rays(groups, index);
  const Sampling sampling = RC_GATHER_SAMPLING();
#if RC_BUNDLE && !RC_MOVING
  Closest closest;
  for (uint k = 0; k < RC_SLOTS; k += 16u) rc_store16((float16)(0.0f), 0, closest.near + k);
  GroupFrame frame;
  frame.rays = group;
#if RC_SCATTER
  Scatter samples;
  rc_scatter_samples(&samples, sampling, seed, place, first_sample, sample_count);
  frame.samples = &samples;
#else
  frame.sampling = sampling;
  frame.first_row = first_sample / RC_NU;
  frame.rows = sample_count / RC_NU;
  frame.columns = place.used * RC_NU;
#endif
  if (!rc_primary_group(scene, &frame, RC_PRIMARY_BUDGET(place.used * sample_count), &closest)) {
    rc_primary_alone(scene, group, place, sampling, seed, first_sample, sample_count, columns, hits);
    return;
  }
#if RC_SCATTER
  for (uint p = 0; p < place.used; ++p) {
    global uint* out = hits + RC_HITS_AT(place.pixel + p);
    for (uint word = 0; word < RC_NEAR_WORDS; ++word) {
      const int16 none = rc_load16(p * RC_NEAR_WORDS + word, closest.near) == 0.0f;
      rc_store16(select(rc_load16(p * RC_NEAR_WORDS + word, closest.instance), (uint16)(RC_NONE), none), word, out);
      rc_store16(select(rc_load16(p * RC_NEAR_WORDS + word, closest.primitive), (uint16)(RC_NONE), none), word,
                 out + RC_HIT_PLANE(RC_HIT_PRIMITIVE));
    }
  }
#else
  global uint* out = hits + RC_HITS_AT(place.pixel);
  rc_write_pixels(closest.near, closest.instance, place.used, frame.rows, out, RC_HITS_AT(1));
  rc_write_pixels(closest.near, closest.primitive, place.used, frame.rows, out + RC_HIT_PLANE(RC_HIT_PRIMITIVE),
                  RC_HITS_AT(1));
#endif
#else
  rc_primary_alone(scene, group, place, sampling, seed, first_sample, sample_count, columns, hits);
#endif
}

kernel void trace_primary(RC_PARAMETERS(RC_TRACE_PRIMARY_ARGUMENTS)) {
  trace_primary_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_PRIMARY_ARGUMENTS));
}
