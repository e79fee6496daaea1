/* The point and normal of a hit, as exact as single precision allows, and the origin of the rays that leave it. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SURFACE_POINT_H
#define RAYCUBE_KERNELS_GEOMETRY_SURFACE_POINT_H

#include "kernels/geometry/triangle.h"

typedef struct SurfacePoint {
  float4 position;  /* m, scene frame, moved off the surface to the viewer's side by its error bound */
  float4 normal;    /* unit, geometric, towards the viewer */
} SurfacePoint;

/* Rounding unit of a float. */
#define RC_ULP 5.9604644775390625e-8f

static inline float rc_dot3(float4 a, float4 b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }

/* a.x b.y - a.y b.x and so on, each component to 1.5 ulp (Kahan's difference of products). */
static inline float rc_product_difference(float a, float b, float c, float d) {
  const float cd = c * d, error = fma(-c, d, cd);
  return fma(a, b, -cd) + error;
}
static inline float4 rc_cross(float4 a, float4 b) {
  return (float4)(rc_product_difference(a.y, b.z, a.z, b.y), rc_product_difference(a.z, b.x, a.x, b.z),
                  rc_product_difference(a.x, b.y, a.y, b.x), 0.0f);
}

static inline float4 rc_vertex(global const TriBlock* block, uint corner, uint lane) {
  global const float* at = (global const float*)block + 48u * corner + lane;
  return (float4)(at[0], at[16], at[32], 0.0f);
}

/* sum_j |row_j| |p_j| + |translation|: what rounding in rc_map_point is relative to. */
static inline float rc_map_size(float4 r, float4 p) { return fma(r.x, p.x, fma(r.y, p.y, fma(r.z, p.z, r.w))); }
static inline float4 rc_map_sizes(float4 r0, float4 r1, float4 r2, float4 p) {
  const float4 q = fabs(p);
  return (float4)(rc_map_size(fabs(r0), q), rc_map_size(fabs(r1), q), rc_map_size(fabs(r2), q), 0.0f);
}

/* Moves the point along +-normal out of the box of its possible errors and rounds away from the surface. */
static inline float rc_step_off(float p, float error, float n, float reach) {
  const float q = fma(n, reach, p);
  return q + copysign(fmax(fabs(q), error) * (2.0f * RC_ULP), n);
}

/* direction: the primary ray's, unnormalised. The intersection is taken in the mesh's own frame about the ray's origin:
 * t = n.(v0 - o) / n.d, then one correction by the plane's residual at the rounded point. The error bound holds for the
 * local point (sums of at most 6 rounded terms of its size, doubled so that a bundle of shadow rays is sure of its own triangle), its way to the scene frame and the way back that a shadow ray
 * takes, each 4 roundings of the sums of absolute products, and both matrices' own rounding. */
static inline SurfacePoint rc_surface_point(global const TriBlock* blocks, global const Instance* placed, uint primitive,
                                            float4 origin, float4 direction) {
  const float4 l0 = placed->local_from_world_0, l1 = placed->local_from_world_1, l2 = placed->local_from_world_2;
  const float4 w0 = placed->world_from_local_0, w1 = placed->world_from_local_1, w2 = placed->world_from_local_2;
  global const TriBlock* block = blocks + primitive / RC_BLOCK;
  const uint lane = primitive % RC_BLOCK;
  const bool same = placed->flags & 1u;
  const float4 o = same ? origin : rc_map_point(l0, l1, l2, origin);
  const float4 d = same ? direction : rc_map_vector(l0, l1, l2, direction);
  const float4 v0 = rc_vertex(block, 0, lane), v1 = rc_vertex(block, 1, lane), v2 = rc_vertex(block, 2, lane);
  const float4 n = rc_cross(v1 - v0, v2 - v0);
  const float nd = rc_dot3(n, d);
  float4 p = fma((float4)(rc_dot3(n, v0 - o) / nd), d, o);
  p = fma((float4)(rc_dot3(n, v0 - p) / nd), d, p);
  /* A grazing ray or sliver can throw the point off its triangle: it stays in the triangle's box. */
  p = fmin(fmax(p, fmin(v0, fmin(v1, v2))), fmax(v0, fmax(v1, v2)));

  /* Normals go by the transposed inverse. */
  float4 normal = same ? n : (float4)(fma(l0.x, n.x, fma(l1.x, n.y, l2.x * n.z)), fma(l0.y, n.x, fma(l1.y, n.y, l2.y * n.z)),
                                      fma(l0.z, n.x, fma(l1.z, n.y, l2.z * n.z)), 0.0f);
  const float largest = fmax(fabs(normal.x), fmax(fabs(normal.y), fabs(normal.z)));
  normal /= largest;
  normal /= sqrt(rc_dot3(normal, normal));
  if (rc_dot3(normal, direction) > 0.0f) normal = -normal;

  SurfacePoint surface;
  const float4 point = same ? p : rc_map_point(w0, w1, w2, p);
  /* Bound of the local point: rounding of p itself and of the plane's evaluation at it. */
  const float4 here = (fabs(p) + fmax(fabs(v0), fmax(fabs(v1), fabs(v2)))) * (8.0f * RC_ULP);
  float4 error = here;
  if (!same) {
    const float4 back = rc_map_sizes(l0, l1, l2, point) * (6.0f * RC_ULP) + here;
    error = (float4)(fma(fabs(w0.x), back.x, fma(fabs(w0.y), back.y, fabs(w0.z) * back.z)),
                     fma(fabs(w1.x), back.x, fma(fabs(w1.y), back.y, fabs(w1.z) * back.z)),
                     fma(fabs(w2.x), back.x, fma(fabs(w2.y), back.y, fabs(w2.z) * back.z)), 0.0f) +
            rc_map_sizes(w0, w1, w2, p) * (6.0f * RC_ULP);
  }
  const float reach = rc_dot3(fabs(normal), error);
  surface.position = (float4)(rc_step_off(point.x, error.x, normal.x, reach), rc_step_off(point.y, error.y, normal.y, reach),
                              rc_step_off(point.z, error.z, normal.z, reach), 0.0f);
  surface.normal = normal;
  return surface;
}

#endif
