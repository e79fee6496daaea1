/* Whether one ray meets a placed tree at all: how the sky's rays, the sun's single ones and ways to a LIDAR's receiver
 * walk. The triangles are those of rc_trace_ray, so both say the same; what differs is the order, which cannot change
 * the answer. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_TREE_HIDES_H
#define RAYCUBE_KERNELS_GEOMETRY_TREE_HIDES_H

#include "kernels/geometry/box_ray.h"

/* Words of a stack past RC_STACK: rc_pack8 writes eight at a time, and rc_any_hit sets one node aside. */
#define RC_STACK_SPARE 9

/* The node to go on with: of the children in `inner` that of the highest slot, the others go onto the stack; with none,
 * what lies topmost there. A child goes from node to node without the stack, whose way through memory each node would
 * wait for. */
static inline uint rc_next_node(global const BvhNode* node, uint inner, uint* stack, uint* top) {
  const uint slot = 31u - clz(inner | 1u), beneath = stack[*top - 1u], child = node->child[slot];
  rc_pack8(node->child, inner & ~(1u << slot), stack + *top);
  *top += popcount(inner) - 1u;
  return inner ? child : beneath;
}

/* Whether the ray (in the frame of the tree) meets a triangle below a node of a placed tree nearer than `limit`. The
 * stack is used from `base` on, and base is at least 1. */
RC_ALWAYS static inline bool rc_tree_hides_from(SceneArrays scene, uint next, Ray ray, const BoxRay* boxes, float limit,
                                                uint* stack, uint base) {
  uint top = base;
  while (top >= base) {
    global const BvhNode* node = rc_node(scene, next);
    const uint met = rc_boxes_met(node, boxes, limit);
    for (uint leaves = met & node->leaf_mask; leaves; leaves &= leaves - 1u) {
      float16 t;
      const uint hit = rc_hit_block(ray, false, rc_block(scene, node->child[rc_lowest(leaves)]), &t);
      if (limit < INFINITY ? hit & rc_mask16(t < limit) : hit) return true;
    }
    next = rc_next_node(node, met & ~node->leaf_mask, stack, &top);
  }
  return false;
}

/* The same from the root on. */
RC_ALWAYS static inline bool rc_tree_hides(SceneArrays scene, uint root, Ray ray, float limit, uint* stack, uint base) {
  const BoxRay boxes = rc_box_ray(ray, rc_node(scene, root)->reach, RC_MESH_SLACK);
  return rc_tree_hides_from(scene, root, ray, &boxes, limit, stack, base);
}

#endif
