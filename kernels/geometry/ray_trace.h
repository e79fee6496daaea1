/* One ray at a time through the two-level tree: moving poses, paths of light, pulses, and the plain form that bundles
 * are tested against. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_RAY_TRACE_H
#define RAYCUBE_KERNELS_GEOMETRY_RAY_TRACE_H

#include "kernels/geometry/box_ray.h"
#include "kernels/geometry/user_order.h"

typedef struct Hit {
  float t; /* in units of the direction's length; INFINITY: none */
  uint instance, primitive;
} Hit;

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

/* Puts the children that a ray meets no farther than `limit` onto the stack, the nearest topmost: above, as bits, where
 * the ray comes to the box, at 0 or beyond; below, the child. As whole numbers they are in the order of that distance.
 * What comes to be hit does not depend on their order; how soon boxes lie beyond it does. */
RC_ALWAYS static inline uint rc_push_met(global const BvhNode* node, const BoxRay* boxes, float limit, ulong* stack,
                                         uint top) {
  float8 enter;
  uint met = rc_boxes_entered(node, boxes, limit, &enter);
  float at[8];
  vstore8(enter, 0, at);
  for (const uint first = top; met; met &= met - 1u) {
    const uint slot = rc_lowest(met), child = node->child[slot] | (node->leaf_mask >> slot & 1u ? RC_LEAF : 0u);
    const ulong entry = (ulong)as_uint(at[slot]) << 32 | child;
    uint k = top++;
    for (; k > first && stack[k - 1u] < entry; --k) stack[k] = stack[k - 1u];
    stack[k] = entry;
  }
  return top;
}

/* A box at the distance of what is hit may hold a hit as near: what the test of boxes rounds, and some. */
static inline float rc_limit_of(const Hit* hit) { return hit->t * 1.0000008f; }

/* The ray through one placed tree. The stack is used from `base` upwards. */
static inline void rc_trace_instance(SceneArrays scene, uint instance, Ray world, ulong* stack, uint base, Hit* hit) {
  global const Instance* placed = rc_instance(scene, instance);
  Ray ray = world;
  if (!(placed->flags & 1u)) {
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    ray = rc_make_ray(rc_map_point(r0, r1, r2, world.origin), rc_map_vector(r0, r1, r2, world.direction));
    if (RC_OFFSETS) ray.offset = rc_map_vector(r0, r1, r2, world.offset);
  }
  const BoxRay boxes = rc_box_ray(ray, rc_node(scene, placed->root)->reach, RC_MESH_SLACK);
  uint top = rc_push_met(rc_node(scene, placed->root), &boxes, rc_limit_of(hit), stack, base);
  while (top > base) {
    const ulong next = stack[--top];
    if (as_float((uint)(next >> 32)) > rc_limit_of(hit)) continue;
    const uint child = (uint)next & ~RC_LEAF;
    if (!((uint)next & RC_LEAF)) {
      top = rc_push_met(rc_node(scene, child), &boxes, rc_limit_of(hit), stack, top);
      continue;
    }
    float16 t;
    const uint lanes = rc_hit_block(ray, RC_OFFSETS, rc_block(scene, child), &t);
    if (lanes) rc_take_closest(scene, hit, instance, child, lanes, t);
  }
}

/* Not inlined, for compile time; unused where all rays go in bundles. The offset counts where RC_OFFSETS is set. Leaves
 * of the top tree are instances; each is traced to its end before the next. */
__attribute__((noinline, unused)) static Hit rc_trace_from(SceneArrays scene, float4 origin, float4 offset,
                                                           float4 direction) {
  Hit hit;
  hit.t = INFINITY;
  hit.instance = RC_NONE;
  hit.primitive = RC_NONE;
  Ray world = rc_make_ray(origin, direction);
  if (RC_OFFSETS) world.offset = offset;
  const BoxRay boxes = rc_box_ray(world, rc_node(scene, 0u)->reach, RC_WORLD_SLACK);
  ulong stack[RC_STACK];
  uint top = rc_push_met(rc_node(scene, 0u), &boxes, rc_limit_of(&hit), stack, 0u);
  while (top) {
    const ulong next = stack[--top];
    if (as_float((uint)(next >> 32)) > rc_limit_of(&hit)) continue;
    const uint child = (uint)next & ~RC_LEAF;
    if ((uint)next & RC_LEAF)
      rc_trace_instance(scene, child, world, stack, top, &hit);
    else
      top = rc_push_met(rc_node(scene, child), &boxes, rc_limit_of(&hit), stack, top);
  }
  return hit;
}

static inline Hit rc_trace_ray(SceneArrays scene, float4 origin, float4 direction) {
  return rc_trace_from(scene, origin, (float4)(0.0f), direction);
}

#endif
