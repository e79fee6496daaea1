/* Rays that rise more steeply than anything of the ground stands around the place below them: what is known of them
 * before they are traced. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SKYLINE_H
#define RAYCUBE_KERNELS_GEOMETRY_SKYLINE_H

#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/triangle.h"

/* The ground's grid (scene_compiler/skyline.h), in the frame of its tree. */
typedef struct Skyline {
  uint instance; /* RC_NONE: there is none */
  float x, y, per_cell;
  uint columns, rows;
  global const float* cells; /* [row][column][2] */
} Skyline;

#define RC_GATHER_SKYLINE() \
  { skyline_instance, skyline_frame.x, skyline_frame.y, skyline_frame.z, skyline_columns, skyline_rows, skyline_cells }

/* Whether a ray is known to miss all of the ground. point, direction: scene frame; left: the instance whose surface the
 * ray leaves, on the side that it goes to. A ray steeper than the skyline is steeper than the surface's own slope, so
 * one that leaves the ground does so on its upper side. */
static inline bool rc_above_skyline(SceneArrays scene, const Skyline* skyline, uint left, float4 point,
                                    float4 direction) {
  if (skyline->instance == RC_NONE) return false;
  global const Instance* placed = rc_instance(scene, skyline->instance);
  if (!(placed->flags & 1u)) {
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    point = rc_map_point(r0, r1, r2, point);
    direction = rc_map_vector(r0, r1, r2, direction);
  }
  const float x = (point.x - skyline->x) * skyline->per_cell, y = (point.y - skyline->y) * skyline->per_cell;
  if (!(direction.z > 0.0f && x >= 0.0f && y >= 0.0f && x < (float)skyline->columns && y < (float)skyline->rows))
    return false;
  global const float* cell = skyline->cells + 2u * ((uint)y * skyline->columns + (uint)x);
  const float flat = fma(direction.x, direction.x, direction.y * direction.y);
  return direction.z * direction.z > cell[1] * flat && (left == skyline->instance || point.z >= cell[0]);
}

#endif
