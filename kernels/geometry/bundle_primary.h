/* A group's primary rays, all from one origin, through one traversal of the two-level tree. A buffer of 1 / t and ids, one slot
 * per sample, keeps the closest hits. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_BUNDLE_PRIMARY_H
#define RAYCUBE_KERNELS_GEOMETRY_BUNDLE_PRIMARY_H

#include "kernels/geometry/primary_grid.h"
#include "kernels/geometry/primary_scatter.h"

/* frame: rays in the scene frame and the samples; the rest is set here. */
static inline void rc_primary_group(SceneArrays scene, GroupFrame frame, Closest* closest) {
  Cull world, cull;
  const RayGroup rays = frame.rays;
  frame.world = rays;
  frame.same = true;
  rc_frame_group(&frame, &world);
  const Projection world_map = frame.map;
  cull = world;
  Open open;
  open.count = 0;
  uint stack[RC_STACK];
  uint top = 1, base = 0, instance = RC_NONE;  /* entries from base upwards belong to the instance's tree */
  stack[0] = 0;
  while (top) {
    if (top == base) {
      if (open.count) rc_decide(scene, &frame, closest, instance, &open);
      instance = RC_NONE;
      base = 0;
      cull = world;
    }
    const uint entry = stack[--top], index = entry & ~RC_LEAF;
    if (!(entry & RC_LEAF)) {
      top = rc_push_children(&cull, 4, scene, index, instance != RC_NONE, stack, top);
    } else if (instance != RC_NONE) {
      rc_primary_block(scene, &frame, closest, &open, index, instance);
    } else {
      global const Instance* placed = rc_instance(scene, index);
      instance = index;
      frame.same = placed->flags & 1u;
      if (frame.same) {
        frame.rays = rays;
        frame.map = world_map;
      } else {
        const float4 r0 = frame.l0 = placed->local_from_world_0, r1 = frame.l1 = placed->local_from_world_1, r2 = frame.l2 = placed->local_from_world_2;
        frame.rays.origin = rc_map_point(r0, r1, r2, rays.origin);
        frame.rays.d0 = rc_map_vector(r0, r1, r2, rays.d0);
        frame.rays.du = rc_map_vector(r0, r1, r2, rays.du);
        frame.rays.dv = rc_map_vector(r0, r1, r2, rays.dv);
        rc_frame_group(&frame, &cull);
      }
      stack[top] = placed->root;
      base = top++;
    }
  }
  if (open.count) rc_decide(scene, &frame, closest, instance, &open);
}

#endif
