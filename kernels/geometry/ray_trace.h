/* One ray at a time through the two-level tree: moving poses, and the plain form that bundles are tested against. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_RAY_TRACE_H
#define RAYCUBE_KERNELS_GEOMETRY_RAY_TRACE_H

#include "kernels/geometry/scene_arrays.h"
#include "kernels/geometry/triangle.h"
#include "kernels/geometry/user_order.h"

typedef struct Hit {
  float t; /* in units of the direction's length; INFINITY: none */
  uint instance, primitive;
} Hit;

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
 *   5   here: origin plus offset 1, plus slack 1, difference 1, inverse 1, product 1.
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

/* Sets the origins that box tests use. */
static inline void rc_slacken(Ray* ray, float reach, float ulps) {
  const float4 start = ray->origin + ray->offset, size = fabs(ray->origin) + fabs(ray->offset);
  const float4 slack = (float4)(ulps * RC_ULP * (reach + fmax(size.x, fmax(size.y, size.z))));
  ray->lo_origin = start + slack;
  ray->hi_origin = start - slack;
}

/* Boxes of a node that the ray meets, within its slack, at a distance below t_max. */
static inline uint rc_ray_boxes(Ray ray, global const BvhNode* node, float t_max) {
  const float4 lo = ray.lo_origin, hi = ray.hi_origin;
  const float8 x0 = (vload8(0, node->lo_x) - lo.x) * ray.inverse.x, x1 = (vload8(0, node->hi_x) - hi.x) * ray.inverse.x;
  const float8 y0 = (vload8(0, node->lo_y) - lo.y) * ray.inverse.y, y1 = (vload8(0, node->hi_y) - hi.y) * ray.inverse.y;
  const float8 z0 = (vload8(0, node->lo_z) - lo.z) * ray.inverse.z, z1 = (vload8(0, node->hi_z) - hi.z) * ray.inverse.z;
  const float8 enter = rc_max8(rc_max8(rc_min8(x0, x1), rc_min8(y0, y1)), rc_max8(rc_min8(z0, z1), 0.0f));
  const float8 leave = rc_min8(rc_min8(rc_max8(x0, x1), rc_max8(y0, y1)), rc_max8(z0, z1));
  return rc_mask8((enter <= leave) & (enter <= t_max * 1.0000008f)) & ((1u << node->count) - 1u);
}

/* Keeps the smallest t, of equal ones that which goes before by the user's order; ties are told by 1 / t, as a bundle
 * that starts at the sensor keeps it. */
static inline void rc_take_closest(SceneArrays scene, Hit* hit, uint instance, uint block, uint lanes, float16 t) {
  float lane_t[16];
  rc_store16(t, 0, lane_t);
  while (lanes) {
    const uint lane = rc_lowest(lanes), primitive = block * RC_BLOCK + lane;
    lanes &= lanes - 1u;
    const float near = 1.0f / lane_t[lane], before = 1.0f / hit->t;
    const bool first = near == before && rc_user_before(scene, instance, primitive, hit->instance, hit->primitive);
    if (near > before || first) {
      hit->t = lane_t[lane];
      hit->instance = instance;
      hit->primitive = primitive;
    }
  }
}

/* The ray through one placed tree. The stack is used from `base` upwards. */
static inline void rc_trace_instance(SceneArrays scene, uint instance, Ray world, uint* stack, uint base,
                                     Hit* hit) {
  global const Instance* placed = rc_instance(scene, instance);
  Ray ray = world;
  if (!(placed->flags & 1u)) {
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    ray = rc_make_ray(rc_map_point(r0, r1, r2, world.origin), rc_map_vector(r0, r1, r2, world.direction));
    if (RC_OFFSETS) ray.offset = rc_map_vector(r0, r1, r2, world.offset);
  }
  rc_slacken(&ray, rc_node(scene, placed->root)->reach, RC_MESH_SLACK);
  uint top = base;
  stack[top++] = placed->root;
  while (top > base) {
    global const BvhNode* node = rc_node(scene, stack[--top]);
    uint boxes = rc_ray_boxes(ray, node, hit->t);
    while (boxes) {
      const uint slot = rc_lowest(boxes), child = node->child[slot];
      boxes &= boxes - 1u;
      if (!(node->leaf_mask >> slot & 1u)) {
        stack[top++] = child;
        continue;
      }
      float16 t;
      const uint lanes = rc_hit_block(ray, RC_OFFSETS, rc_block(scene, child), &t);
      if (lanes) rc_take_closest(scene, hit, instance, child, lanes, t);
    }
  }
}

/* Not inlined, for compile time; unused where all rays go in bundles. The offset counts where RC_OFFSETS is set. */
__attribute__((noinline, unused)) static Hit rc_trace_from(SceneArrays scene, float4 origin, float4 offset,
                                                           float4 direction) {
  Hit hit;
  hit.t = INFINITY;
  hit.instance = RC_NONE;
  hit.primitive = RC_NONE;
  Ray world = rc_make_ray(origin, direction);
  if (RC_OFFSETS) world.offset = offset;
  rc_slacken(&world, rc_node(scene, 0u)->reach, RC_WORLD_SLACK);
  uint stack[RC_STACK];
  uint top = 1;
  stack[0] = 0;
  while (top) {
    global const BvhNode* node = rc_node(scene, stack[--top]);
    uint boxes = rc_ray_boxes(world, node, hit.t);
    uint leaves = boxes & node->leaf_mask;
    boxes &= ~node->leaf_mask;
    while (boxes) {
      stack[top++] = node->child[rc_lowest(boxes)];
      boxes &= boxes - 1u;
    }
    while (leaves) { /* leaves of the top tree are instances; each is traced to its end before the next */
      const uint instance = node->child[rc_lowest(leaves)];
      leaves &= leaves - 1u;
      rc_trace_instance(scene, instance, world, stack, top, &hit);
    }
  }
  return hit;
}

static inline Hit rc_trace_ray(SceneArrays scene, float4 origin, float4 direction) {
  return rc_trace_from(scene, origin, (float4)(0.0f), direction);
}

#endif
