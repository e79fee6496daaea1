/* Ray against 16 triangles at once, watertight: Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT
 * 2(1),
 * 2013. Each vertex is moved to the ray's frame by one formula, so triangles that share it see the same point; products
 * are rounded alone (no contraction), so the sign of an edge function is right or the function is zero, and zero counts
 * as inside. A ray at an edge or vertex of a closed surface therefore hits at least one of the triangles that meet
 * there. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_TRIANGLE_H
#define RAYCUBE_KERNELS_GEOMETRY_TRIANGLE_H

#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/lanes.h"

/* A ray in one frame, with what the tests need. Axes are numbered x y z = 0 1 2. */
typedef struct Ray {
  float4 origin, direction; /* m; direction of any length, not zero */
  float4 offset;            /* m, small: the ray starts at origin + offset, a sum that is never rounded */
  float4 inverse;           /* 1 / direction, finite: zeros become 1e18 with their sign */
  int kx, ky, kz;           /* kz: largest direction component */
  float sx, sy, sz;         /* shear and scale of Woop's transform */
} Ray;

static inline float rc_component(float4 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static inline float rc_safe_inverse(float d) { return 1.0f / (fabs(d) < 1e-18f ? copysign(1e-18f, d) : d); }

static inline Ray rc_make_ray(float4 origin, float4 direction) {
  Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.offset = (float4)(0.0f);
  ray.inverse =
      (float4)(rc_safe_inverse(direction.x), rc_safe_inverse(direction.y), rc_safe_inverse(direction.z), 0.0f);
  const float x = fabs(direction.x), y = fabs(direction.y), z = fabs(direction.z);
  ray.kz = z >= x && z >= y ? 2 : y >= x ? 1 : 0;
  ray.kx = ray.kz == 2 ? 0 : ray.kz + 1;
  ray.ky = 3 - ray.kz - ray.kx;
  const float dz = rc_component(direction, ray.kz);
  ray.sx = rc_component(direction, ray.kx) / dz;
  ray.sy = rc_component(direction, ray.ky) / dz;
  ray.sz = 1.0f / dz;
  return ray;
}

/* Affine map by three rows. */
static inline float4 rc_map_point(float4 r0, float4 r1, float4 r2, float4 p) {
  return (float4)(fma(r0.x, p.x, fma(r0.y, p.y, fma(r0.z, p.z, r0.w))),
                  fma(r1.x, p.x, fma(r1.y, p.y, fma(r1.z, p.z, r1.w))),
                  fma(r2.x, p.x, fma(r2.y, p.y, fma(r2.z, p.z, r2.w))), 0.0f);
}
static inline float4 rc_map_vector(float4 r0, float4 r1, float4 r2, float4 v) {
  return (float4)(fma(r0.x, v.x, fma(r0.y, v.y, r0.z * v.z)), fma(r1.x, v.x, fma(r1.y, v.y, r1.z * v.z)),
                  fma(r2.x, v.x, fma(r2.y, v.y, r2.z * v.z)), 0.0f);
}

/* Positive where the plane of the triangle lies ahead of the origin: n.(a - o) and n.d of one sign, n from the
 * triangle's own edges e1, e2; p = a - o in the ray's axes. The distance interpolated from the corners cancels numbers
 * as large as the corners are far: on a court line 20 m long and 5 cm wide it is wrong by 0.5 mm, more than the offset
 * of a shadow ray, and the line shadowed itself. */
static inline float16 rc_ahead16(const float16* e1, const float16* e2, const float16* p, float16 sx, float16 sy,
                                 float16 sz) {
  const float16 nx = e1[1] * e2[2] - e1[2] * e2[1], ny = e1[2] * e2[0] - e1[0] * e2[2],
                nz = e1[0] * e2[1] - e1[1] * e2[0];
  const float16 from_origin = fma(nx, p[0], fma(ny, p[1], nz * p[2]));
  const float16 along = fma(nx, sx, fma(ny, sy, nz)) * sz;
  return select(-from_origin, from_origin, along > 0.0f);
}

/* The test itself, 16 pairs of a ray and a triangle. a, b, c: corners, o: origin, all in the axes of the ray (kx, ky,
 * kz); off: its offset there, or 0 (the pointer) for none; sx, sy, sz: its shear and scale. Bit i: pair i hits at a
 * distance *t above 0; *t is set when a bit is. */
RC_ALWAYS static inline uint rc_hit_pairs(const float16* a, const float16* b, const float16* c, const float16* o,
                                          const float16* off, float16 sx, float16 sy, float16 sz, float16* t) {
  float16 az = a[2] - o[2], bz = b[2] - o[2], cz = c[2] - o[2];
  float16 ax = fma(-sx, az, a[0] - o[0]), ay = fma(-sy, az, a[1] - o[1]);
  float16 bx = fma(-sx, bz, b[0] - o[0]), by = fma(-sy, bz, b[1] - o[1]);
  float16 cx = fma(-sx, cz, c[0] - o[0]), cy = fma(-sy, cz, c[1] - o[1]);
  if (off) { /* shear is linear: the offset's is taken off after it */
    const float16 x = fma(-sx, off[2], off[0]), y = fma(-sy, off[2], off[1]);
    ax -= x;
    bx -= x;
    cx -= x;
    ay -= y;
    by -= y;
    cy -= y;
    az -= off[2];
    bz -= off[2];
    cz -= off[2];
  }
  const float16 u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
  const float16 least = rc_min16(u, rc_min16(v, w)), most = rc_max16(u, rc_max16(v, w));
  const float16 det = u + (v + w);
  const int16 inside = ((least >= 0.0f) | (most <= 0.0f)) & (det != 0.0f);
  if (!rc_mask16(inside)) return 0u; /* most blocks: the ray goes between the triangles */
  /* Interpolated, it may fall behind where the plane lies ahead: such a hit is at the origin. */
  *t = rc_max16(fma(u, az, fma(v, bz, w * cz)) * sz / det, (float16)(1e-30f));
  const float16 e1[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, e2[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const float16 p[3] = {off ? (a[0] - o[0]) - off[0] : a[0] - o[0], off ? (a[1] - o[1]) - off[1] : a[1] - o[1], az};
  return rc_mask16(inside & (rc_ahead16(e1, e2, p, sx, sy, sz) > 0.0f));
}

/* One ray against the 16 triangles of a block. offset: whether the ray may have one; without, it is not looked at. */
RC_ALWAYS static inline uint rc_hit_block(Ray ray, bool offset, global const TriBlock* block, float16* t) {
  global const float* at = (global const float*)block;
  const int x = 16 * ray.kx, y = 16 * ray.ky, z = 16 * ray.kz;
  const float16 a[3] = {rc_load16(0, at + x), rc_load16(0, at + y), rc_load16(0, at + z)};
  const float16 b[3] = {rc_load16(0, at + 48 + x), rc_load16(0, at + 48 + y), rc_load16(0, at + 48 + z)};
  const float16 c[3] = {rc_load16(0, at + 96 + x), rc_load16(0, at + 96 + y), rc_load16(0, at + 96 + z)};
  const float16 o[3] = {(float16)(rc_component(ray.origin, ray.kx)), (float16)(rc_component(ray.origin, ray.ky)),
                        (float16)(rc_component(ray.origin, ray.kz))};
  const float16 off[3] = {(float16)(rc_component(ray.offset, ray.kx)), (float16)(rc_component(ray.offset, ray.ky)),
                          (float16)(rc_component(ray.offset, ray.kz))};
  return rc_hit_pairs(a, b, c, o, offset ? off : 0, (float16)(ray.sx), (float16)(ray.sy), (float16)(ray.sz), t);
}

#endif
