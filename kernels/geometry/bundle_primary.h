/* A group's primary rays, all from one origin, through one traversal of the two-level tree. A buffer of nearness and
 * ids, one slot per sample, keeps the closest hits. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_BUNDLE_PRIMARY_H
#define RAYCUBE_KERNELS_GEOMETRY_BUNDLE_PRIMARY_H

#include "kernels/geometry/primary_grid.h"
#include "kernels/geometry/primary_scatter.h"

/* Nodes and blocks that a bundle may visit. It has no order and no end: where its pixels hold whole trees it would walk
 * every leaf of them, and a ray by itself is done after some tens of nodes. A constant; where it is spent in vain the
 * group takes up to four times what single rays alone would (docs/speed.md). It changes time, never a result. */
#define RC_PRIMARY_BUDGET(rays) (128u + 16u * (rays))

/* frame: rays in the scene frame and the samples; the rest is set here. false: the budget is spent and nothing is
 * found. */
static inline bool rc_primary_group(SceneArrays scene, GroupFrame* frame, uint budget, Closest* closest) {
  GroupFrame placed; /* the group in the frame of an instance that is moved */
  Cull world_cull, placed_cull;
  frame->world = frame->rays;
  frame->same = true;
  placed = *frame;
  placed.same = false;
  rc_frame_group(scene, 0u, frame, &world_cull);
  placed.map.near_0 = frame->map.near_0;
  placed.map.near_1 = frame->map.near_1;
  const GroupFrame* here = frame;
  const Cull* cull = &world_cull;
  Pending pending;
  rc_begin_pending(&pending);
  uint stack[RC_STACK];
  uint top = 1, base = 0, instance = RC_NONE; /* entries from base upwards belong to the instance's tree */
  stack[0] = 0;
  for (uint visits = 0; top; ++visits) {
    if (visits == budget) return false;
    if (top == base) {
      rc_settle(scene, here, closest, instance, &pending);
      instance = RC_NONE;
      base = 0;
      here = frame;
      cull = &world_cull;
    }
    const uint entry = stack[--top], index = entry & ~RC_LEAF;
    if (!(entry & RC_LEAF)) {
      top = rc_push_children(cull, 4, scene, index, instance != RC_NONE, stack, top);
    } else if (instance != RC_NONE) {
      rc_primary_block(scene, here, closest, &pending, index, instance);
    } else {
      global const Instance* moved = rc_instance(scene, index);
      instance = index;
      if (!(moved->flags & 1u)) {
        const float4 r0 = placed.l0 = moved->local_from_world_0, r1 = placed.l1 = moved->local_from_world_1,
                     r2 = placed.l2 = moved->local_from_world_2;
        placed.rays.origin = rc_map_point(r0, r1, r2, frame->rays.origin);
        placed.rays.d0 = rc_map_vector(r0, r1, r2, frame->rays.d0);
        placed.rays.du = rc_map_vector(r0, r1, r2, frame->rays.du);
        placed.rays.dv = rc_map_vector(r0, r1, r2, frame->rays.dv);
        rc_frame_group(scene, moved->root, &placed, &placed_cull);
        here = &placed;
        cull = &placed_cull;
      }
      stack[top] = moved->root;
      base = top++;
    }
  }
  rc_settle(scene, here, closest, instance, &pending);
  return true;
}

#endif
