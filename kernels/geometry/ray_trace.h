/* One ray at a time through the two-level tree: moving poses, and the plain form that bundles are tested against. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_RAY_TRACE_H
#define RAYCUBE_KERNELS_GEOMETRY_RAY_TRACE_H

#include "kernels/geometry/scene_arrays.h"
#include "kernels/geometry/triangle.h"

typedef struct Hit {
  float t;                   /* in units of the direction's length; INFINITY: none */
  uint instance, primitive;
} Hit;

/* Boxes of a node that the ray meets at a distance below t_max. Conservative: the far side is pushed out by the rounding of
 * a difference and a product on either side (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013). */
static inline uint rc_ray_boxes(Ray ray, global const BvhNode* node, float t_max) {
  const float8 x0 = (vload8(0, node->lo_x) - ray.origin.x) * ray.inverse.x, x1 = (vload8(0, node->hi_x) - ray.origin.x) * ray.inverse.x;
  const float8 y0 = (vload8(0, node->lo_y) - ray.origin.y) * ray.inverse.y, y1 = (vload8(0, node->hi_y) - ray.origin.y) * ray.inverse.y;
  const float8 z0 = (vload8(0, node->lo_z) - ray.origin.z) * ray.inverse.z, z1 = (vload8(0, node->hi_z) - ray.origin.z) * ray.inverse.z;
  const float8 enter = rc_max8(rc_max8(rc_min8(x0, x1), rc_min8(y0, y1)), rc_max8(rc_min8(z0, z1), 0.0f));
  const float8 leave = rc_min8(rc_min8(rc_max8(x0, x1), rc_max8(y0, y1)), rc_max8(z0, z1)) * 1.0000008f;
  return rc_mask8((enter <= leave) & (enter <= t_max * 1.0000008f)) & ((1u << node->count) - 1u);
}

/* Keeps the smallest (t, instance, primitive). */
static inline void rc_take_closest(Hit* hit, uint instance, uint block, uint lanes, float16 t) {
  float lane_t[16];
  rc_store16(t, 0, lane_t);
  while (lanes) {
    const uint lane = rc_lowest(lanes), primitive = block * RC_BLOCK + lane;
    lanes &= lanes - 1u;
    const bool first = lane_t[lane] == hit->t &&
                       (instance < hit->instance || (instance == hit->instance && primitive < hit->primitive));
    if (lane_t[lane] < hit->t || first) {
      hit->t = lane_t[lane];
      hit->instance = instance;
      hit->primitive = primitive;
    }
  }
}

/* The ray through one placed mesh. The stack is used from `base` upwards. */
static inline void rc_trace_instance(SceneArrays scene, uint instance, Ray world, uint* stack, uint base, bool any, Hit* hit) {
  global const Instance* placed = rc_instance(scene, instance);
  Ray ray = world;
  if (!(placed->flags & 1u)) {
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    ray = rc_make_ray(rc_map_point(r0, r1, r2, world.origin), rc_map_vector(r0, r1, r2, world.direction));
  }
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
      const uint lanes = rc_hit_block(ray, rc_block(scene, child), &t);
      if (lanes) rc_take_closest(hit, instance, child, lanes, t);
      if (any && lanes) return;
    }
  }
}

/* Not inlined, for compile time; unused where all rays go in bundles. Closest hit; with `any` set, returns at the first hit
 * found, whichever it is. */
__attribute__((noinline, unused)) static Hit rc_trace_ray(SceneArrays scene, float4 origin, float4 direction, bool any) {
  Hit hit;
  hit.t = INFINITY;
  hit.instance = RC_NONE;
  hit.primitive = RC_NONE;
  const Ray world = rc_make_ray(origin, direction);
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
    while (leaves) {  /* leaves of the top tree are instances; each is traced to its end before the next */
      const uint instance = node->child[rc_lowest(leaves)];
      leaves &= leaves - 1u;
      rc_trace_instance(scene, instance, world, stack, top, any, &hit);
      if (any && hit.instance != RC_NONE) return hit;
    }
  }
  return hit;
}

#endif
