/* One ray that asks only whether anything lies ahead of it: the sky's rays, each its own way. The boxes and triangles
 * are those of rc_trace_ray, so both say the same; what differs is the order, which cannot change the answer. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_ANY_HIT_H
#define RAYCUBE_KERNELS_GEOMETRY_ANY_HIT_H

#include "kernels/geometry/ray_trace.h"

/* A ray as box tests read it: its start moved by the slack of a tree, sides of boxes by the signs of its direction. */
typedef struct BoxRay {
  float4 near, far, inverse;
  uint x, y, z; /* of the near sides: floats into a node; the far ones lie 24 further or nearer */
} BoxRay;

static inline BoxRay rc_box_ray(Ray ray, float reach, float ulps) {
  BoxRay out;
  rc_slacken(&ray, reach, ulps);
  out.near = select(ray.hi_origin, ray.lo_origin, ray.inverse >= 0.0f);
  out.far = select(ray.lo_origin, ray.hi_origin, ray.inverse >= 0.0f);
  out.inverse = ray.inverse;
  out.x = ray.inverse.x < 0.0f ? 24u : 0u;
  out.y = ray.inverse.y < 0.0f ? 32u : 8u;
  out.z = ray.inverse.z < 0.0f ? 40u : 16u;
  return out;
}

/* Children whose boxes the ray meets, at any distance. */
static inline uint rc_boxes_met(global const BvhNode* node, const BoxRay* ray) {
  global const float* at = (global const float*)node;
  const float8 enter = rc_max8(rc_max8((vload8(0, at + ray->x) - ray->near.x) * ray->inverse.x,
                                       (vload8(0, at + ray->y) - ray->near.y) * ray->inverse.y),
                               rc_max8((vload8(0, at + ray->z) - ray->near.z) * ray->inverse.z, 0.0f));
  const float8 leave = rc_min8(rc_min8((vload8(0, at + 24u - ray->x) - ray->far.x) * ray->inverse.x,
                                       (vload8(0, at + 40u - ray->y) - ray->far.y) * ray->inverse.y),
                               (vload8(0, at + 56u - ray->z) - ray->far.z) * ray->inverse.z);
  return rc_mask8(enter <= leave) & ((1u << node->count) - 1u);
}

/* Whether the ray (in the frame of the tree) meets a triangle of a placed tree. The stack is used from `base` on. */
static inline bool rc_tree_hides(SceneArrays scene, uint root, Ray ray, uint* stack, uint base) {
  const BoxRay boxes = rc_box_ray(ray, rc_node(scene, root)->reach, RC_MESH_SLACK);
  uint top = base;
  stack[top++] = root;
  while (top > base) {
    global const BvhNode* node = rc_node(scene, stack[--top]);
    const uint met = rc_boxes_met(node, &boxes);
    for (uint leaves = met & node->leaf_mask; leaves; leaves &= leaves - 1u) {
      float16 t;
      if (rc_hit_block(ray, false, rc_block(scene, node->child[rc_lowest(leaves)]), &t)) return true;
    }
    top += rc_pack8(node->child, met & ~node->leaf_mask, stack + top);
  }
  return false;
}

/* Whether anything lies ahead of the origin. */
__attribute__((noinline)) static bool rc_any_hit(SceneArrays scene, float4 origin, float4 direction) {
  const Ray world = rc_make_ray(origin, direction);
  const BoxRay boxes = rc_box_ray(world, rc_node(scene, 0u)->reach, RC_WORLD_SLACK);
  uint stack[RC_STACK + 8]; /* rc_pack8 writes eight at a time */
  uint top = 1;
  stack[0] = 0;
  while (top) {
    global const BvhNode* node = rc_node(scene, stack[--top]);
    const uint met = rc_boxes_met(node, &boxes);
    top += rc_pack8(node->child, met & ~node->leaf_mask, stack + top);
    for (uint leaves = met & node->leaf_mask; leaves; leaves &= leaves - 1u) {
      global const Instance* placed = rc_instance(scene, node->child[rc_lowest(leaves)]);
      Ray ray = world;
      if (!(placed->flags & 1u)) {
        const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
        ray = rc_make_ray(rc_map_point(r0, r1, r2, origin), rc_map_vector(r0, r1, r2, direction));
      }
      if (rc_tree_hides(scene, placed->root, ray, stack, top)) return true;
    }
  }
  return false;
}

#endif
