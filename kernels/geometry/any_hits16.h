/* Sixteen rays from about one place that ask whether anything lies ahead of them: the sky's rays of a group of pixels.
 * Answers are those of rc_any_hit, ray by ray. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_ANY_HITS16_H
#define RAYCUBE_KERNELS_GEOMETRY_ANY_HITS16_H

#include "kernels/geometry/any_hit.h"
#include "kernels/geometry/tree_hides16.h"

/* Of `live`, the rays that an instance hides. */
__attribute__((noinline)) static uint rc_instance_hides16(SceneArrays scene, uint instance, const Rays16* world,
                                                          uint live) {
  global const Instance* placed = rc_instance(scene, instance);
  if (placed->flags & 1u) return rc_tree_hides16(scene, placed->root, world, live, false);
  const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
  const Vector16 origin = {rc_load16(0, world->x), rc_load16(0, world->y), rc_load16(0, world->z)};
  const Vector16 way = {rc_load16(0, world->dx), rc_load16(0, world->dy), rc_load16(0, world->dz)};
  Rays16 rays;
  rc_store_rays16(rc_map_points16(r0, r1, r2, origin), rc_map_vectors16(r0, r1, r2, way), &rays);
  return rc_tree_hides16(scene, placed->root, &rays, live, false);
}

/* Of `live`, the rays (scene frame) that meet anything ahead of them; those of `clear` are known to miss the instance
 * `ground`. Every ray is read, so those that are not live are copies of one that is. */
__attribute__((noinline)) static uint rc_any_hits16(SceneArrays scene, const Rays16* rays, uint live, uint ground,
                                                    uint clear) {
  const BoxRays16 boxes = rc_box_rays16(rays, rc_node(scene, 0u)->reach, RC_WORLD_SLACK);
  NodeOf16 stack[RC_STACK];
  uint hidden = 0, top = 1;
  stack[0].node = 0;
  stack[0].rays = live;
  while (top) {
    const NodeOf16 at = stack[--top];
    uint left = at.rays & ~hidden;
    if (!left) continue;
    if (popcount(left) <= RC_FEW_RAYS) {
      for (; left; left &= left - 1u) {
        const uint k = rc_lowest(left);
        if (rc_any_hit_from(scene, at.node, (float4)(rays->x[k], rays->y[k], rays->z[k], 0.0f),
                            (float4)(rays->dx[k], rays->dy[k], rays->dz[k], 0.0f), clear >> k & 1u ? ground : RC_NONE))
          hidden |= 1u << k;
      }
      continue;
    }
    global const BvhNode* node = rc_node(scene, at.node);
    for (uint slot = 0; slot < node->count; ++slot) {
      uint met = rc_box_met16(node, slot, &boxes) & left;
      if (!met) continue;
      if (!(node->leaf_mask >> slot & 1u)) {
        stack[top].node = node->child[slot];
        stack[top].rays = met;
        ++top;
        continue;
      }
      met &= ~hidden;
      if (node->child[slot] == ground) met &= ~clear;
      if (met) hidden |= rc_instance_hides16(scene, node->child[slot], rays, met);
    }
  }
  return hidden;
}

/* The same of the rays `live`, one at least; the others are overwritten. */
static inline uint rc_hidden_of(SceneArrays scene, Rays16* rays, uint live, uint ground, uint clear) {
  const uint k = rc_lowest(live);
  for (uint other = ~live & 0xffffu; other; other &= other - 1u)
    rc_put_ray(rays, rc_lowest(other), (float4)(rays->x[k], rays->y[k], rays->z[k], 0.0f),
               (float4)(rays->dx[k], rays->dy[k], rays->dz[k], 0.0f));
  return rc_any_hits16(scene, rays, live, ground, clear);
}

/* The same of the first `count` rays, 1 to 16. */
static inline uint rc_first_hidden(SceneArrays scene, Rays16* rays, uint count, uint ground, uint clear) {
  return rc_hidden_of(scene, rays, (1u << count) - 1u, ground, clear);
}

#endif
