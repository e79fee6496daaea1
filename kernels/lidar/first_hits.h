/* First hits of an owner's rays, a bundle at once or ray by ray, and the words of 16 that paths begin with. */
#ifndef RAYCUBE_KERNELS_LIDAR_FIRST_HITS_H
#define RAYCUBE_KERNELS_LIDAR_FIRST_HITS_H

#include "kernels/geometry/bundle_primary.h"
#include "kernels/geometry/ray_trace.h"
#include "kernels/lidar/vertex.h"

/* 16 rays: their sub-rays or samples (INFINITY: none), and what they meet first. */
typedef struct HitWord {
  float16 a, b;
  uint16 instances, primitives;
} HitWord;

/* Rays `ray` to ray + 15. */
static inline HitWord rc_trace_word(SceneArrays scene, const LidarTables* t, uint ray) {
  const float4 reference = t->shot[RC_SHOT_REFERENCE], axis = t->shot[RC_SHOT_AXIS], du = t->shot[RC_SHOT_DU],
               dv = t->shot[RC_SHOT_DV], residual = t->shot[RC_SHOT_RESIDUAL];
  const float s = t->shot[RC_SHOT_START].w, back = reference.w;
  HitWord word;
  Hits16 hits;
  word.a = rc_load16(0, t->samples + 2u * ray);
  word.b = rc_load16(1, t->samples + 2u * ray);
  RC_LINE float lane_a[16], lane_b[16];
  rc_store16(word.a, 0, lane_a);
  rc_store16(word.b, 0, lane_b);
  for (uint k = 0; k < 16u; ++k) {
    hits.instance[k] = RC_NONE;
    hits.primitive[k] = 0;
    if (!(lane_a[k] < INFINITY)) continue;
    const float4 tilt = fma((float4)(lane_a[k]), du, lane_b[k] * dv);
    float4 offset = residual;
    if (RC_HAS(t, EXITS))
      offset += fma((float4)(t->exits[ray + k]), t->shot[RC_SHOT_EXIT_U],
                    t->exits[rc_padded_rays(t) + ray + k] * t->shot[RC_SHOT_EXIT_V]);
    const float4 direction = axis + tilt,
                 origin = reference + fma((float4)(-back), direction, fma((float4)(s), tilt, offset));
    const Hit hit = rc_trace_ray(scene, (float4)(origin.xyz, 0.0f), (float4)(direction.xyz, 0.0f));
    hits.instance[k] = hit.instance;
    if (hit.instance != RC_NONE) hits.primitive[k] = hit.primitive;
  }
  word.instances = rc_load16(0, hits.instance);
  word.primitives = rc_load16(0, hits.primitive);
  return word;
}

/* All rays of one bundle; rays: how many. */
static inline void rc_trace_bundle(SceneArrays scene, const LidarTables* t, global const Scatter* scatter, uint rays,
                                   Closest* closest) {
  const uint words = (rays + RC_WORD - 1u) / RC_WORD;
  for (uint word = 0; word < words; ++word) rc_store16((float16)(0.0f), word, closest->near);
  GroupFrame frame;
  frame.rays.origin = t->shot[RC_SHOT_START];
  frame.rays.d0 = t->shot[RC_SHOT_AXIS];
  frame.rays.du = t->shot[RC_SHOT_DU];
  frame.rays.dv = t->shot[RC_SHOT_DV];
  frame.rays.origin.w = frame.rays.d0.w = frame.rays.du.w = frame.rays.dv.w = 0.0f;
  frame.rays.ov = (float4)(0.0f);
  frame.half_a = frame.half_b = 0.5f * t->settings[RC_SET_SUPPORT];
  frame.samples = scatter;
  frame.words = words;
  if (rc_primary_group(scene, &frame, RC_PRIMARY_BUDGET(RC_WORD * words), closest)) return;
  for (uint k = 0; k < RC_WORD * words; ++k) { /* ray by ray */
    const float a = scatter->a[k], b = scatter->b[k];
    closest->near[k] = 0.0f;
    if (!(a < INFINITY)) continue;
    const Hit hit = rc_trace_ray(scene, frame.rays.origin,
                                 fma((float4)(b), frame.rays.dv, fma((float4)(a), frame.rays.du, frame.rays.d0)));
    if (hit.instance == RC_NONE) continue;
    closest->near[k] = 1.0f;
    closest->instance[k] = hit.instance;
    closest->primitive[k] = hit.primitive;
  }
}

/* Rays `slot` to slot + 15 of a bundle that was traced. */
static inline HitWord rc_word_of_bundle(global const Scatter* scatter, const Closest* closest, uint slot) {
  HitWord word;
  word.a = rc_load16(0, scatter->a + slot);
  word.b = rc_load16(0, scatter->b + slot);
  const int16 none = rc_load16(0, closest->near + slot) == 0.0f;
  word.instances = select(rc_load16(0, closest->instance + slot), (uint16)(RC_NONE), none);
  word.primitives = select(rc_load16(0, closest->primitive + slot), (uint16)(0u), none);
  return word;
}

/* Files the hits of rays `ray` to ray + 15 of an owner: [owner][ray]: instance, primitive. */
static inline void rc_write_hits(const LidarTables* t, const HitWord* word, uint owner, uint ray,
                                 global uint* first_hits) {
  RC_LINE uint instance_of[16], primitive_of[16];
  rc_store16(word->instances, 0, instance_of);
  rc_store16(word->primitives, 0, primitive_of);
  for (uint k = 0; k < 16u; ++k) {
    global uint* to = first_hits + 2u * ((size_t)owner * rc_padded_rays(t) + ray + k);
    to[0] = instance_of[k];
    to[1] = instance_of[k] == RC_NONE ? RC_NONE : primitive_of[k];
  }
}

#endif
