/* One ray that asks only whether anything lies ahead of it: the sky's rays, each its own way, and a LIDAR's ways from
 * where light was scattered to its receiver. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_ANY_HIT_H
#define RAYCUBE_KERNELS_GEOMETRY_ANY_HIT_H

#include "kernels/geometry/tree_hides.h"

/* Whether anything below a node of the top tree lies ahead of the origin, nearer than `limit` lengths of `direction`.
 * Leaves of the top tree are placed trees, each walked to its end before the top tree is gone on with. passed: an
 * instance that is not asked, since the ray is known to miss it; RC_NONE: none. */
RC_ALWAYS static inline bool rc_any_before(SceneArrays scene, uint next, float4 origin, float4 direction, float limit,
                                           uint passed) {
  const Ray world = rc_make_ray(origin, direction);
  const BoxRay boxes = rc_box_ray(world, rc_node(scene, 0u)->reach, RC_WORLD_SLACK);
  uint stack[RC_STACK + RC_STACK_SPARE];
  uint top = 1;
  stack[0] = 0;
  while (top) {
    global const BvhNode* node = rc_node(scene, next);
    const uint met = rc_boxes_met(node, &boxes, limit);
    next = rc_next_node(node, met & ~node->leaf_mask, stack, &top);
    stack[top] = next;
    for (uint leaves = met & node->leaf_mask; leaves; leaves &= leaves - 1u) {
      const uint instance = node->child[rc_lowest(leaves)];
      if (instance == passed) continue;
      global const Instance* placed = rc_instance(scene, instance);
      Ray ray = world;
      if (!(placed->flags & 1u)) {
        const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
        ray = rc_make_ray(rc_map_point(r0, r1, r2, origin), rc_map_vector(r0, r1, r2, direction));
      }
      if (rc_tree_hides(scene, placed->root, ray, limit, stack, top + 1u)) return true;
    }
  }
  return false;
}

/* Whether anything lies ahead of the origin, at any distance. Not inlined, for compile time; each is unused in the
 * programs that send no such ray. */
__attribute__((noinline, unused)) static bool rc_any_hit(SceneArrays scene, float4 origin, float4 direction) {
  return rc_any_before(scene, 0u, origin, direction, INFINITY, RC_NONE);
}

/* The same of what lies below a node of the top tree, but for one instance. */
__attribute__((noinline, unused)) static bool rc_any_hit_from(SceneArrays scene, uint node, float4 origin,
                                                              float4 direction, uint passed) {
  return rc_any_before(scene, node, origin, direction, INFINITY, passed);
}

/* Whether anything lies between a point and the end of a way from it. */
__attribute__((noinline, unused)) static bool rc_way_blocked(SceneArrays scene, float4 from, float4 way) {
  return rc_any_before(scene, 0u, from, way, 1.0f, RC_NONE);
}

#endif
