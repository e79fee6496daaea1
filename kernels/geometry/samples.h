/* Where the rays of a group go: samples of its pixels in group coordinates (a, b), in pixels about the group's centre.
 * */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SAMPLES_H
#define RAYCUBE_KERNELS_GEOMETRY_SAMPLES_H

#include "kernels/geometry/trace_args.h"

/* Place of a work-item's group in its tile and in the image. */
typedef struct GroupPlace {
  uint pixel;  /* first pixel: index in the tile */
  uint number; /* first pixel: index in the image, for hashes */
  uint used;   /* pixels that exist, 1 .. pixels_per_group */
} GroupPlace;

static inline GroupPlace rc_group_place(const TileShape* tile, global const RayGroup* groups, uint group,
                                        uint columns) {
  const uint per_line = rc_groups_per_line(columns, tile->pixels_per_group);
  const uint line = group / per_line, column = (group - line * per_line) * tile->pixels_per_group;
  GroupPlace place;
  place.pixel = line * columns + column;
  place.number = as_uint(groups[group].origin.w);
  place.used = min(tile->pixels_per_group, columns - column);
  return place;
}

/* A group's rays, without the number: as a float it would be subnormal, which is slow. d0.w stays: how far ahead of the
 * sensor they start. */
static inline RayGroup rc_group_rays(global const RayGroup* groups, uint group) {
  RayGroup rays = groups[group];
  rays.origin.w = 0.0f;
  return rays;
}

/* How a pixel's samples lie (kernels/sampling/sampler.h). */
typedef struct Sampling {
  int kind; /* RC_SAMPLER_* */
  uint nu, nv;
  float support; /* pixels */
  float left;    /* middle of a group's first pixel, pixels from the group's */
} Sampling;
static inline float rc_left_of_group(const TileShape* tile) { return -0.5f * (float)(tile->pixels_per_group - 1u); }
#define RC_GATHER_SAMPLING() \
  { (int)sampler, samples_u, samples_v, sample_support, rc_left_of_group(&tile) }

/* (a, b) of sample s of the group's pixel p, whose number in the image is `number`. */
static inline void rc_group_sample(Sampling of, uint seed, uint number, uint p, uint s, float* a, float* b) {
  float u, v;
  rc_sample_uv(of.kind, (int)of.nu, (int)of.nv, of.support, seed, number, (int)s, &u, &v);
  *a = ((float)p + of.left) + u;
  *b = v;
}

/* The same of samples s to s + 15; a lattice is moved once for all of them. */
static inline void rc_group_samples(Sampling of, uint seed, uint number, uint p, uint s, float* a, float* b) {
  const float left = (float)p + of.left;
  if (of.kind != RC_SAMPLER_LATTICE) {
    for (uint k = 0; k < 16u; ++k) rc_group_sample(of, seed, number, p, s + k, a + k, b + k);
    return;
  }
  const LatticeShift shift = rc_lattice_shift(seed, number);
  for (uint k = 0; k < 16u; ++k) {
    float x, y;
    rc_lattice_xy((int)(of.nu * of.nv), shift, (int)(s + k), &x, &y);
    a[k] = left + (x - 0.5f) * of.support;
    b[k] = (y - 0.5f) * of.support;
  }
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
  offset = fma((float4)(b), g.ov, offset);
  offset.w = 0.0f;
  return offset;
}

#endif
