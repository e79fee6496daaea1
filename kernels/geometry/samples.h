/* Where the rays of a group go: samples of its pixels in group coordinates (a, b), in pixels about the group's centre.
 * */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SAMPLES_H
#define RAYCUBE_KERNELS_GEOMETRY_SAMPLES_H

#include "kernels/geometry/trace_args.h"

/* Place of a work-item's group in its tile and in the image. */
typedef struct GroupPlace {
  uint pixel;  /* first pixel: index in the tile */
  uint number; /* first pixel: index in the image, for hashes */
  uint used;   /* pixels that exist, 1 .. RC_PIXELS_PER_GROUP */
} GroupPlace;

static inline GroupPlace rc_group_place(global const RayGroup* groups, uint group, uint columns) {
  const uint per_line = rc_groups_per_line(columns, RC_PIXELS_PER_GROUP);
  const uint line = group / per_line, column = (group - line * per_line) * RC_PIXELS_PER_GROUP;
  GroupPlace place;
  place.pixel = line * columns + column;
  place.number = as_uint(groups[group].origin.w);
  place.used = min((uint)RC_PIXELS_PER_GROUP, columns - column);
  return place;
}

/* A group's rays, without the number: as a float it would be subnormal, which is slow. d0.w stays: how far ahead of the
 * sensor they start. */
static inline RayGroup rc_group_rays(global const RayGroup* groups, uint group) {
  RayGroup rays = groups[group];
  rays.origin.w = 0.0f;
  return rays;
}

/* (a, b) of sample s of the group's pixel p, whose number in the image is `number`. */
static inline void rc_group_sample(uint seed, uint number, uint p, uint s, float* a, float* b) {
  float u, v;
  rc_sample_uv(RC_SAMPLER, RC_NU, RC_NV, RC_SUPPORT, seed, number, (int)s, &u, &v);
  *a = ((float)p - 0.5f * (float)(RC_PIXELS_PER_GROUP - 1)) + u;
  *b = v;
}

static inline float4 rc_group_direction(RayGroup g, float a, float b) {
  float4 direction = fma((float4)(b), g.dv, fma((float4)(a), g.du, g.d0));
  direction.w = 0.0f;
  return direction;
}

/* Where the ray of (a, b) starts, from the group's origin: as far ahead of the sensor as that, near what it will meet.
 * A start 20 km off would round every difference from it to 1 mm. */
static inline float4 rc_group_offset(RayGroup g, float a, float b) {
  float4 offset = fma((float4)(b * g.d0.w), g.dv, (float4)(a * g.d0.w) * g.du);
#if RC_MOVING
  offset = fma((float4)(b), g.ov, offset);
#endif
  offset.w = 0.0f;
  return offset;
}

#endif
