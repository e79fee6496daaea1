/* One side of the surfaces that sixteen rays met, gathered instance by instance. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SURFACE_SIDE_H
#define RAYCUBE_KERNELS_GEOMETRY_SURFACE_SIDE_H

#include "kernels/geometry/surface_point.h"
#include "kernels/shared/tile_layout.h"

typedef struct SurfaceSide16 {
  Vector16 position; /* m, scene frame: off the surface on this side */
  Vector16 normal;   /* unit, to this side */
  float16 lift;      /* m, how far along the normal the point was moved */
} SurfaceSide16;

static inline void rc_clear_side(SurfaceSide16* side) {
  side->position.x = side->position.y = side->position.z = 0.0f;
  side->normal.x = side->normal.y = side->normal.z = 0.0f;
  side->lift = 0.0f;
}

/* Of `lanes` those of another. */
static inline void rc_take_side(const SurfaceSide16* from, int16 lanes, SurfaceSide16* side) {
  side->position.x = select(side->position.x, from->position.x, lanes);
  side->position.y = select(side->position.y, from->position.y, lanes);
  side->position.z = select(side->position.z, from->position.z, lanes);
  side->normal.x = select(side->normal.x, from->normal.x, lanes);
  side->normal.y = select(side->normal.y, from->normal.y, lanes);
  side->normal.z = select(side->normal.z, from->normal.z, lanes);
  side->lift = select(side->lift, from->lift, lanes);
}

/* The side that rays of this direction come to, of one instance's triangles: of `lanes`; the others stay. */
static inline void rc_find_side(global const Instance* placed, const Vector16* v, Vector16 origin, Vector16 direction,
                                int16 lanes, SurfaceSide16* side) {
  SurfaceSide16 here;
  rc_surface_points(placed, v, origin, direction, &here.position, &here.normal, &here.lift);
  rc_take_side(&here, lanes, side);
}

/* Into a word's slots of the planes of a tile. */
static inline void rc_store_side(const SurfaceSide16* side, global float* surface, global float* lift) {
  rc_store16(side->position.x, 0, surface + RC_PLANE(RC_POINT_X));
  rc_store16(side->position.y, 0, surface + RC_PLANE(RC_POINT_Y));
  rc_store16(side->position.z, 0, surface + RC_PLANE(RC_POINT_Z));
  rc_store16(side->normal.x, 0, surface + RC_PLANE(RC_NORMAL_X));
  rc_store16(side->normal.y, 0, surface + RC_PLANE(RC_NORMAL_Y));
  rc_store16(side->normal.z, 0, surface + RC_PLANE(RC_NORMAL_Z));
  rc_store16(side->lift, 0, lift);
}

#endif
