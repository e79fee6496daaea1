/* A point of a surface, off it by its error bound along the normal so that rays that leave it do not meet it, and back.
 * */
#ifndef RAYCUBE_KERNELS_GEOMETRY_LIFT_H
#define RAYCUBE_KERNELS_GEOMETRY_LIFT_H

#include "kernels/geometry/lanes.h"

/* Moves a coordinate by n * reach and rounds away from the surface. */
static inline float16 rc_step_off(float16 p, float16 error, float16 n, float16 reach) {
  const float16 q = fma(n, reach, p);
  return q + copysign(fmax(fabs(q), error) * (2.0f * RC_ULP), n);
}
/* The way back, for what is told of the surface itself: to one rounding of p where p is larger than its error, else to
 * 2 ulp of that. */
static inline float16 rc_step_back(float16 p, float16 n, float16 reach) {
  return fma(-n, reach, p - copysign(fabs(p) * (2.0f * RC_ULP), n));
}

#endif
