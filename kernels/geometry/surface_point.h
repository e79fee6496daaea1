/* The point and normal of a hit, as exact as single precision allows, and the origin of the rays that leave it. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SURFACE_POINT_H
#define RAYCUBE_KERNELS_GEOMETRY_SURFACE_POINT_H

#include "kernels/geometry/lift.h"
#include "kernels/geometry/triangle.h"

/* Three components of 16 samples. */
typedef struct Vector16 {
  float16 x, y, z;
} Vector16;

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

/* sum_j |row_j| |p_j| + |translation|: what rounding in rc_map_point is relative to. */
static inline float rc_map_size(float4 r, float4 p) { return fma(r.x, p.x, fma(r.y, p.y, fma(r.z, p.z, r.w))); }
static inline float4 rc_map_sizes(float4 r0, float4 r1, float4 r2, float4 p) {
  const float4 q = fabs(p);
  return (float4)(rc_map_size(fabs(r0), q), rc_map_size(fabs(r1), q), rc_map_size(fabs(r2), q), 0.0f);
}

static inline float16 rc_dot16(Vector16 a, Vector16 b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
static inline float16 rc_product_difference16(float16 a, float16 b, float16 c, float16 d) {
  const float16 cd = c * d, error = fma(-c, d, cd);
  return fma(a, b, -cd) + error;
}
static inline Vector16 rc_minus16(Vector16 a, Vector16 b) {
  Vector16 r = {a.x - b.x, a.y - b.y, a.z - b.z};
  return r;
}
static inline float16 rc_map16(float4 r, Vector16 p, float w) {
  return fma((float16)(r.x), p.x, fma((float16)(r.y), p.y, fma((float16)(r.z), p.z, (float16)(w))));
}
static inline Vector16 rc_map_points16(float4 r0, float4 r1, float4 r2, Vector16 p) {
  Vector16 r = {rc_map16(r0, p, r0.w), rc_map16(r1, p, r1.w), rc_map16(r2, p, r2.w)};
  return r;
}
static inline Vector16 rc_map_vectors16(float4 r0, float4 r1, float4 r2, Vector16 v) {
  Vector16 r = {fma((float16)(r0.x), v.x, fma((float16)(r0.y), v.y, r0.z * v.z)),
                fma((float16)(r1.x), v.x, fma((float16)(r1.y), v.y, r1.z * v.z)),
                fma((float16)(r2.x), v.x, fma((float16)(r2.y), v.y, r2.z * v.z))};
  return r;
}
static inline Vector16 rc_abs16(Vector16 v) {
  Vector16 r = {fabs(v.x), fabs(v.y), fabs(v.z)};
  return r;
}
static inline float16 rc_most3(float16 a, float16 b, float16 c) { return fmax(fabs(a), fmax(fabs(b), fabs(c))); }

/* From p along d to the plane of v0 and n. */
static inline Vector16 rc_to_plane(Vector16 p, Vector16 d, Vector16 n, Vector16 v0, float16 nd) {
  const float16 t = rc_dot16(n, rc_minus16(v0, p)) / nd;
  Vector16 r = {fma(t, d.x, p.x), fma(t, d.y, p.y), fma(t, d.z, p.z)};
  return r;
}
static inline float16 rc_clamp_to(float16 p, float16 a, float16 b, float16 c) {
  return fmin(fmax(p, fmin(a, fmin(b, c))), fmax(a, fmax(b, c)));
}

/* Position (m, scene frame, moved off the surface to the viewer's side by its error bound, `lift`, m) and normal (unit,
 * geometric, towards the viewer) of 16 samples that hit the same instance; v: their triangles' corners. origin,
 * direction: the primary rays, unnormalised, scene frame. The intersection is taken in the mesh's own frame about the
 * ray's origin: t = n.(v0 - o) / n.d, then one correction by the plane's residual at the rounded point. The error bound
 * holds for the local point (sums of at most 6 rounded terms of its size, doubled so that a bundle of shadow rays is
 * sure of its own triangle), its way to the scene frame and the way back that a shadow ray takes, each 4 roundings of
 * the sums of absolute products, and both matrices' own rounding. */
static inline void rc_surface_points(global const Instance* placed, const Vector16* v, Vector16 origin,
                                     Vector16 direction, Vector16* position, Vector16* towards_viewer, float16* lift) {
  const float4 l0 = placed->local_from_world_0, l1 = placed->local_from_world_1, l2 = placed->local_from_world_2;
  const float4 w0 = placed->world_from_local_0, w1 = placed->world_from_local_1, w2 = placed->world_from_local_2;
  const bool same = placed->flags & 1u;
  Vector16 o = origin, d = direction;
  if (!same) {
    o = rc_map_points16(l0, l1, l2, origin);
    d.x = rc_map16(l0, direction, 0.0f);
    d.y = rc_map16(l1, direction, 0.0f);
    d.z = rc_map16(l2, direction, 0.0f);
  }
  const Vector16 e1 = rc_minus16(v[1], v[0]), e2 = rc_minus16(v[2], v[0]);
  Vector16 n;
  n.x = rc_product_difference16(e1.y, e2.z, e1.z, e2.y);
  n.y = rc_product_difference16(e1.z, e2.x, e1.x, e2.z);
  n.z = rc_product_difference16(e1.x, e2.y, e1.y, e2.x);
  const float16 nd = rc_dot16(n, d);
  Vector16 p = rc_to_plane(o, d, n, v[0], nd);
  p = rc_to_plane(p, d, n, v[0], nd);
  /* A grazing ray or sliver can throw the point off its triangle: it stays in the triangle's box. */
  p.x = rc_clamp_to(p.x, v[0].x, v[1].x, v[2].x);
  p.y = rc_clamp_to(p.y, v[0].y, v[1].y, v[2].y);
  p.z = rc_clamp_to(p.z, v[0].z, v[1].z, v[2].z);

  const Vector16 size = {fabs(p.x) + rc_most3(v[0].x, v[1].x, v[2].x), fabs(p.y) + rc_most3(v[0].y, v[1].y, v[2].y),
                         fabs(p.z) + rc_most3(v[0].z, v[1].z, v[2].z)};
  const float16 here = 8.0f * RC_ULP;
  /* Shadow rays meet the triangle in a frame turned towards their direction, where every coordinate's rounding reaches
   * the depth: no axis may have less than its share of all three, or level ground at z = 0 would have no bound at all.
   * */
  const float16 shared_error = (size.x + size.y + size.z) * (4.0f * RC_ULP);
  Vector16 error = {fmax(size.x * here, shared_error), fmax(size.y * here, shared_error),
                    fmax(size.z * here, shared_error)};
  Vector16 normal = n, point = p;
  if (!same) {
    point = rc_map_points16(w0, w1, w2, p);
    const Vector16 way_back = rc_map_points16(fabs(l0), fabs(l1), fabs(l2), rc_abs16(point));
    const Vector16 way_out = rc_map_points16(fabs(w0), fabs(w1), fabs(w2), rc_abs16(p));
    const float16 way = 6.0f * RC_ULP;
    const Vector16 back = {fma(way_back.x, way, error.x), fma(way_back.y, way, error.y), fma(way_back.z, way, error.z)};
    error.x = fma(way_out.x, way, rc_map16(fabs(w0), back, 0.0f));
    error.y = fma(way_out.y, way, rc_map16(fabs(w1), back, 0.0f));
    error.z = fma(way_out.z, way, rc_map16(fabs(w2), back, 0.0f));
    /* Normals go by the transposed inverse. */
    normal.x = fma((float16)(l0.x), n.x, fma((float16)(l1.x), n.y, l2.x * n.z));
    normal.y = fma((float16)(l0.y), n.x, fma((float16)(l1.y), n.y, l2.y * n.z));
    normal.z = fma((float16)(l0.z), n.x, fma((float16)(l1.z), n.y, l2.z * n.z));
  }
  const float16 largest = rc_most3(normal.x, normal.y, normal.z);
  normal.x /= largest;
  normal.y /= largest;
  normal.z /= largest;
  const float16 length = copysign(sqrt(rc_dot16(normal, normal)), -rc_dot16(normal, direction));
  normal.x /= length;
  normal.y /= length;
  normal.z /= length;
  const float16 reach = rc_dot16(rc_abs16(normal), error);
  position->x = rc_step_off(point.x, error.x, normal.x, reach);
  position->y = rc_step_off(point.y, error.y, normal.y, reach);
  position->z = rc_step_off(point.z, error.z, normal.z, reach);
  *towards_viewer = normal;
  *lift = reach;
}

#endif
