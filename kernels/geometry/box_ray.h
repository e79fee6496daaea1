/* One ray against the boxes of a node, and how far outside a box a ray may pass. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_BOX_RAY_H
#define RAYCUBE_KERNELS_GEOMETRY_BOX_RAY_H

#include "kernels/geometry/scene_arrays.h"
#include "kernels/geometry/triangle.h"

/* How far outside a box, in ulp of M = the tree's reach plus the largest coordinate of the ray's origin, a ray may pass
 * and still be given a hit by rc_hit_block, plus what the box test itself rounds. In a mesh's frame, at the depth of
 * the hit:
 *   6   the sheared corners: difference 1, quotient of the shear 1, its product and sum 3 (the shear is at most 1),
 *   less the offset 1;
 *   24  edge functions: two products that round to one number count as zero, so a ray is inside while no farther from
 *   an edge
 *       than 2 ulp |b| |c| / |b - c|: for the longest edge E of a triangle around it at most 1.4 E, E at most 5.7 M,
 *       and three times that beyond a corner (half as much again where two edges meet at right angles, less at
 *       slivers);
 *   5   here: origin plus offset 1, plus slack 1, inverse 1, its product with the origin 1, multiply-add 1.
 * 34, doubled. Slack moves the ray's origin, not every box, so that a box costs no operation more, and being absolute
 * it holds where a ray runs in a face or starts there: a share of the distance is nothing at distance 0. A direction
 * component of zero has the inverse 1e18: inside the slab by the slack, its interval is -+6e-8 M 1e18, longer than any
 * scene. Rounding is monotone and child boxes lie inside their parents, so a ray that meets a leaf's box meets all
 * above it. In the scene's frame the slack of a mesh comes back through a rotation and scale (|W| |L| <= 3), with the
 * map of the origin (4) and of the direction (3): 3 (64 + 7) = 213; the boxes there carry the rounding of both matrices
 * already. Not covered: a triangle seen edge-on, narrower on the shear plane than its rounding. Its edge functions are
 * all rounding, and may let a ray in anywhere on the triangle's extension. Nor is a sliver behind the origin whose
 * normal, all rounding too, tells that it lies ahead (rc_ahead16). There a bundle and a single ray can differ: 1 of 73
 * 728 shadow rays aimed at lines of 30 m x
 * 5 cm in tilted planes, from anywhere between 1e-7 and 8000 m off. */
#define RC_MESH_SLACK 64.0f
#define RC_WORLD_SLACK 256.0f

/* A ray as box tests read it: a side at s is met at the distance s * inverse + start, rounded as often as
 * (s - origin) * inverse, for which RC_MESH_SLACK counts. */
typedef struct BoxRay {
  float4 inverse, near, far; /* near, far: starts of near and far sides, -inverse times the origin moved by the slack */
  uint x, y, z;              /* of the near sides: floats into a node; the far ones lie 24 further or nearer */
} BoxRay;

static inline BoxRay rc_box_ray(Ray ray, float reach, float ulps) {
  BoxRay out;
  const float4 start = ray.origin + ray.offset, size = fabs(ray.origin) + fabs(ray.offset);
  const float4 slack = (float4)(ulps * RC_ULP * (reach + fmax(size.x, fmax(size.y, size.z))));
  const float4 lo = start + slack, hi = start - slack; /* origins for the lower and the upper sides of boxes */
  out.near = -ray.inverse * select(hi, lo, ray.inverse >= 0.0f);
  out.far = -ray.inverse * select(lo, hi, ray.inverse >= 0.0f);
  out.inverse = ray.inverse;
  out.x = ray.inverse.x < 0.0f ? 24u : 0u;
  out.y = ray.inverse.y < 0.0f ? 32u : 8u;
  out.z = ray.inverse.z < 0.0f ? 40u : 16u;
  return out;
}

static inline float8 rc_box_side(global const float* sides, float inverse, float start) {
  return fma(vload8(0, sides), (float8)(inverse), (float8)(start));
}

/* Children whose boxes the ray meets nearer than `limit`, which compilers fold away where it is INFINITY; enter: where
 * it comes to each box, at 0 or beyond. */
RC_ALWAYS static inline uint rc_boxes_entered(global const BvhNode* node, const BoxRay* ray, float limit,
                                              float8* enter) {
  global const float* at = (global const float*)node;
  *enter = rc_max8(rc_max8(rc_box_side(at + ray->x, ray->inverse.x, ray->near.x),
                           rc_box_side(at + ray->y, ray->inverse.y, ray->near.y)),
                   rc_max8(rc_box_side(at + ray->z, ray->inverse.z, ray->near.z), 0.0f));
  float8 leave = rc_min8(rc_min8(rc_box_side(at + 24u - ray->x, ray->inverse.x, ray->far.x),
                                 rc_box_side(at + 40u - ray->y, ray->inverse.y, ray->far.y)),
                         rc_box_side(at + 56u - ray->z, ray->inverse.z, ray->far.z));
  if (limit < INFINITY) leave = rc_min8(leave, (float8)(limit));
  return rc_mask8(*enter <= leave) & ((1u << node->count) - 1u);
}

/* The same for whom it is enough to know which. */
RC_ALWAYS static inline uint rc_boxes_met(global const BvhNode* node, const BoxRay* ray, float limit) {
  float8 enter;
  return rc_boxes_entered(node, ray, limit, &enter);
}

#endif
