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

#define RC_NOTHING (~0ul) /* no child to go on with */

/* Of the children that a ray meets no farther than `limit` the nearest comes back, and goes from node to node without
 * the stack, whose way through memory each node would wait for; the others go onto the stack, the nearer topmost. Of a
 * child: above, as bits, where the ray comes to the box, at 0 or beyond; below, the child. As whole numbers they are in
 * the order of that distance. What comes to be hit does not depend on their order; how soon boxes lie beyond it does.
 * placed: whether leaves are blocks of triangles, which are on their way here while those before them are looked at. */
RC_ALWAYS static inline ulong rc_push_met(SceneArrays scene, bool placed, uint index, const BoxRay* boxes, float limit,
                                          ulong* stack, uint* top) {
  global const BvhNode* node = rc_node(scene, index);
  float8 enter;
  uint met = rc_boxes_entered(node, boxes, limit, &enter);
  float at[8];
  vstore8(enter, 0, at);
  ulong nearest = RC_NOTHING;
  for (const uint first = *top; met; met &= met - 1u) {
    const uint slot = rc_lowest(met), leaf = node->leaf_mask >> slot & 1u, child = node->child[slot];
    if (placed && leaf) rc_prefetch(rc_block(scene, child), 576u);
    if (placed && !leaf) rc_prefetch(rc_node(scene, child), 256u);
    const ulong entry = (ulong)as_uint(at[slot]) << 32 | child | (leaf ? RC_LEAF : 0u), farther = max(entry, nearest);
    nearest = min(entry, nearest);
    if (farther == RC_NOTHING) continue;
    uint k = (*top)++;
    for (; k > first && stack[k - 1u] < farther; --k) stack[k] = stack[k - 1u];
    stack[k] = farther;
  }
  return nearest;
}

/* The topmost child down to `base` that is no farther than `limit`. */
RC_ALWAYS static inline ulong rc_pop_near(const ulong* stack, uint* top, uint base, float limit) {
  while (*top > base) {
    const ulong next = stack[--*top];
    if (as_float((uint)(next >> 32)) <= limit) return next;
  }
  return RC_NOTHING;
}

/* A box at the distance of what is hit may hold a hit as near: what the test of boxes rounds, and some. */
static inline float rc_limit_of(const Hit* hit) { return hit->t * 1.0000008f; }

/* The ray through one placed tree. The stack is used from `base` upwards. moved: whether the ray may have an offset. */
RC_ALWAYS static inline void rc_trace_instance(SceneArrays scene, uint instance, Ray world, bool moved, ulong* stack,
                                               uint base, Hit* hit) {
  global const Instance* placed = rc_instance(scene, instance);
  Ray ray = world;
  if (!(placed->flags & 1u)) {
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    ray = rc_make_ray(rc_map_point(r0, r1, r2, world.origin), rc_map_vector(r0, r1, r2, world.direction));
    if (moved) ray.offset = rc_map_vector(r0, r1, r2, world.offset);
  }
  const BoxRay boxes = rc_box_ray(ray, rc_node(scene, placed->root)->reach, RC_MESH_SLACK);
  uint top = base;
  ulong next = rc_push_met(scene, true, placed->root, &boxes, rc_limit_of(hit), stack, &top);
  for (;;) {
    if (next == RC_NOTHING) next = rc_pop_near(stack, &top, base, rc_limit_of(hit));
    if (next == RC_NOTHING) return;
    const uint child = (uint)next & ~RC_LEAF;
    if (!((uint)next & RC_LEAF)) {
      next = rc_push_met(scene, true, child, &boxes, rc_limit_of(hit), stack, &top);
      continue;
    }
    next = RC_NOTHING;
    float16 t;
    const uint lanes = rc_hit_block(ray, moved, rc_block(scene, child), &t);
    if (lanes) rc_take_closest(scene, hit, instance, child, lanes, t);
  }
}

/* Leaves of the top tree are instances; each is traced to its end before the next. */
RC_ALWAYS static inline void rc_closest(SceneArrays scene, Ray world, bool moved, Hit* hit) {
  hit->t = INFINITY;
  hit->instance = RC_NONE;
  hit->primitive = RC_NONE;
  const BoxRay boxes = rc_box_ray(world, rc_node(scene, 0u)->reach, RC_WORLD_SLACK);
  ulong stack[RC_STACK];
  uint top = 0;
  ulong next = rc_push_met(scene, false, 0u, &boxes, rc_limit_of(hit), stack, &top);
  for (;;) {
    if (next == RC_NOTHING) next = rc_pop_near(stack, &top, 0u, rc_limit_of(hit));
    if (next == RC_NOTHING) return;
    const uint child = (uint)next & ~RC_LEAF;
    if ((uint)next & RC_LEAF) {
      rc_trace_instance(scene, child, world, moved, stack, top, hit);
      next = RC_NOTHING;
    } else {
      next = rc_push_met(scene, false, child, &boxes, rc_limit_of(hit), stack, &top);
    }
  }
}

/* Neither is inlined, for compile time; unused where all rays go in bundles. */
__attribute__((noinline, unused)) static Hit rc_trace_from(SceneArrays scene, float4 origin, float4 offset,
                                                           float4 direction) {
  Ray world = rc_make_ray(origin, direction);
  world.offset = offset;
  Hit hit;
  rc_closest(scene, world, true, &hit);
  return hit;
}

__attribute__((noinline, unused)) static Hit rc_trace_ray(SceneArrays scene, float4 origin, float4 direction) {
  Hit hit;
  rc_closest(scene, rc_make_ray(origin, direction), false, &hit);
  return hit;
}

#endif
