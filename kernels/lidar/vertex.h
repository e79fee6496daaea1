/* Where 16 rays meet their triangles, relative to the owner's reference point, and the surfaces there. */
#ifndef RAYCUBE_KERNELS_LIDAR_VERTEX_H
#define RAYCUBE_KERNELS_LIDAR_VERTEX_H

#include "kernels/geometry/surface_point.h"
#include "kernels/lidar/context.h"

/* 16 rays origin + offset + tau direction. The offset is small against the origin and never added to it before the
 * difference from a triangle's corner is taken. */
typedef struct PulseRays16 {
  Vector16 origin, offset, direction;
} PulseRays16;

typedef struct Hits16 {
  uint instance[16], primitive[16]; /* primitive 0 where nothing was hit */
} RC_LINE Hits16;

typedef struct Vertex16 {
  float16 along;   /* tau */
  Vector16 normal; /* unit, geometric, to the side the ray came from */
  /* m, scene frame: off the surface by its error bound, on the ray's side and behind (RC_POINTS_OFF) */
  Vector16 front, back;
  uint surface[16]; /* 0 in lanes that met nothing */
  uint common;      /* the surface of all lanes that met something; RC_NONE: they differ */
} Vertex16;

static inline Vector16 rc_vector16(float4 v) {
  const Vector16 r = {(float16)(v.x), (float16)(v.y), (float16)(v.z)};
  return r;
}
static inline void rc_store_vector16(Vector16 v, float to[3][16]) {
  rc_store16(v.x, 0, to[0]);
  rc_store16(v.y, 0, to[1]);
  rc_store16(v.z, 0, to[2]);
}
static inline Vector16 rc_load_vector16(float from[3][16]) {
  const Vector16 v = {rc_load16(0, from[0]), rc_load16(0, from[1]), rc_load16(0, from[2])};
  return v;
}
static inline float4 rc_lane4(float from[3][16], uint k) { return (float4)(from[0][k], from[1][k], from[2][k], 0.0f); }

static inline Vector16 rc_plus16(Vector16 a, Vector16 b) {
  const Vector16 r = {a.x + b.x, a.y + b.y, a.z + b.z};
  return r;
}
/* a + f b */
static inline Vector16 rc_along16(Vector16 a, float16 f, Vector16 b) {
  const Vector16 r = {fma(f, b.x, a.x), fma(f, b.y, a.y), fma(f, b.z, a.z)};
  return r;
}
static inline Vector16 rc_turn16(float4 r0, float4 r1, float4 r2, Vector16 v) {
  const Vector16 r = {rc_map16(r0, v, 0.0f), rc_map16(r1, v, 0.0f), rc_map16(r2, v, 0.0f)};
  return r;
}
static inline Vector16 rc_select_vector16(Vector16 a, Vector16 b, int16 take_b) {
  const Vector16 r = {select(a.x, b.x, take_b), select(a.y, b.y, take_b), select(a.z, b.z, take_b)};
  return r;
}

static inline float16 rc_largest16(float16 a, float16 b, float16 c) {
  return rc_max16(fabs(a), rc_max16(fabs(b), fabs(c)));
}
/* Planes of 16 triangles, in their mesh's frame: a corner, the normal (twice the area), the box, the largest number of
 * two corners. */
typedef struct Planes16 {
  Vector16 corner, normal, low, high;
  float16 size;
} Planes16;

static inline float16 rc_low3(float16 a, float16 b, float16 c) { return rc_min16(a, rc_min16(b, c)); }
static inline float16 rc_high3(float16 a, float16 b, float16 c) { return rc_max16(a, rc_max16(b, c)); }

static inline Planes16 rc_planes16(const Vector16* v) {
  Planes16 planes;
  const Vector16 e1 = rc_minus16(v[1], v[0]), e2 = rc_minus16(v[2], v[0]);
  planes.corner = v[0];
  planes.normal.x = rc_product_difference16(e1.y, e2.z, e1.z, e2.y);
  planes.normal.y = rc_product_difference16(e1.z, e2.x, e1.x, e2.z);
  planes.normal.z = rc_product_difference16(e1.x, e2.y, e1.y, e2.x);
  planes.low.x = rc_low3(v[0].x, v[1].x, v[2].x);
  planes.low.y = rc_low3(v[0].y, v[1].y, v[2].y);
  planes.low.z = rc_low3(v[0].z, v[1].z, v[2].z);
  planes.high.x = rc_high3(v[0].x, v[1].x, v[2].x);
  planes.high.y = rc_high3(v[0].y, v[1].y, v[2].y);
  planes.high.z = rc_high3(v[0].z, v[1].z, v[2].z);
  planes.size = rc_max16(rc_largest16(v[0].x, v[0].y, v[0].z), rc_largest16(v[1].x, v[1].y, v[1].z));
  return planes;
}

/* Unit normals in the scene's frame of planes of one instance, to no side in particular. */
static inline Vector16 rc_unit_normals(global const Instance* placed, Vector16 n) {
  Vector16 normal = n;
  if (!(placed->flags & 1u)) { /* normals go by the transposed inverse */
    const float4 l0 = placed->local_from_world_0, l1 = placed->local_from_world_1, l2 = placed->local_from_world_2;
    normal.x = fma((float16)(l0.x), n.x, fma((float16)(l1.x), n.y, l2.x * n.z));
    normal.y = fma((float16)(l0.y), n.x, fma((float16)(l1.y), n.y, l2.y * n.z));
    normal.z = fma((float16)(l0.z), n.x, fma((float16)(l1.z), n.y, l2.z * n.z));
  }
  /* By a power of two near the largest component first: squares of millimetres and kilometres alike stay in range. */
  const float16 largest = rc_max16(rc_largest16(normal.x, normal.y, normal.z), (float16)(1e-30f));
  const float16 scale = as_float16(0x7f000000 - (as_int16(largest) & 0x7f800000));
  normal.x *= scale;
  normal.y *= scale;
  normal.z *= scale;
  const float16 over_length = 1.0f / rc_max16(sqrt(rc_dot16(normal, normal)), (float16)(1e-30f));
  normal.x *= over_length;
  normal.y *= over_length;
  normal.z *= over_length;
  return normal;
}

/* How far p is outside low .. high; NaN where p is. */
static inline float16 rc_beyond16(float16 p, float16 low, float16 high) {
  return rc_max16((float16)(0.0f), rc_max16(p - high, low - p));
}
static inline float16 rc_within16(float16 p, float16 low, float16 high) { return fmin(fmax(p, low), high); }

/* Where rays meet planes of one instance: tau, and which way the planes' normals point. Other lanes than `lanes` come
 * out as numbers nobody reads. */
RC_ALWAYS static inline float16 rc_meet_planes(global const Instance* placed, const Planes16* planes,
                                               const PulseRays16* rays, int16 lanes, float16* against) {
  Vector16 o = rays->origin, s = rays->offset, d = rays->direction;
  if (!(placed->flags & 1u)) {
    const float4 l0 = placed->local_from_world_0, l1 = placed->local_from_world_1, l2 = placed->local_from_world_2;
    o = rc_map_points16(l0, l1, l2, o);
    s = rc_turn16(l0, l1, l2, s);
    d = rc_turn16(l0, l1, l2, d);
  }
  const Vector16 n = planes->normal;
  const float16 nd = rc_dot16(n, d), over_nd = 1.0f / nd;
  const Vector16 to_corner = rc_minus16(rc_minus16(planes->corner, o), s);
  float16 tau = rc_dot16(n, to_corner) * over_nd;
  tau = fma(rc_dot16(n, rc_along16(to_corner, -tau, d)), over_nd, tau);
  /* A grazing ray or sliver can throw the point off its triangle (0 / 0 included): then it is the box's nearest point.
   * */
  const Vector16 start = rc_plus16(o, s), p = rc_along16(start, tau, d);
  const float16 size = rc_max16(planes->size, rc_largest16(o.x, o.y, o.z));
  const float16 off = rc_beyond16(p.x, planes->low.x, planes->high.x) +
                      rc_beyond16(p.y, planes->low.y, planes->high.y) + rc_beyond16(p.z, planes->low.z, planes->high.z);
  const int16 on = off <= size * (256.0f * RC_ULP);
  if (rc_mask16(lanes & ~on)) {
    const Vector16 kept = {rc_within16(p.x, planes->low.x, planes->high.x),
                           rc_within16(p.y, planes->low.y, planes->high.y),
                           rc_within16(p.z, planes->low.z, planes->high.z)};
    tau = select(rc_dot16(rc_minus16(kept, start), d) / rc_dot16(d, d), tau, on);
  }
  *against = -nd;
  return tau;
}

static inline Vector16 rc_turned_to(Vector16 n, float16 against) {
  const int16 sign = as_int16(against) & (int)0x80000000;
  const Vector16 r = {as_float16(as_int16(n.x) ^ sign), as_float16(as_int16(n.y) ^ sign),
                      as_float16(as_int16(n.z) ^ sign)};
  return r;
}

/* A triangle that a whole word met, in every lane: what follows mostly meets it too. */
typedef struct Triangle {
  Planes16 planes;
  Vector16 normal;                   /* unit, in the scene's frame */
  uint instance, primitive, surface; /* instance RC_NONE: none */
} RC_LINE Triangle;

static inline void rc_remember(SceneArrays scene, uint instance, uint primitive, Triangle* triangle) {
  global const TriBlock* block = rc_block(scene, primitive / RC_BLOCK);
  global const float* at = (global const float*)block + primitive % RC_BLOCK;
  Vector16 v[3];
  for (uint c = 0; c < 3u; ++c) {
    v[c].x = at[48u * c];
    v[c].y = at[48u * c + 16u];
    v[c].z = at[48u * c + 32u];
  }
  triangle->planes = rc_planes16(v);
  triangle->normal = rc_unit_normals(rc_instance(scene, instance), triangle->planes.normal);
  triangle->instance = instance;
  triangle->primitive = primitive;
  triangle->surface = block->surface[primitive % RC_BLOCK];
}

/* The vertices of the lanes in `live`. triangle: remembered from word to word, or 0. */
static inline void rc_meet(SceneArrays scene, const LidarTables* t, uint16 instances, uint16 primitives, uint live,
                           const PulseRays16* rays, Triangle* triangle, Vertex16* vertex) {
  RC_LINE uint instance_of[16], primitive_of[16];
  rc_store16(instances, 0, instance_of);
  rc_store16(primitives, 0, primitive_of);
  const uint first = rc_lowest(live), instance = instance_of[first], primitive = primitive_of[first];
  if (!RC_POINTS_OFF(t) && triangle && !(rc_mask16((instances != instance) | (primitives != primitive)) & live)) {
    if (triangle->instance != instance || triangle->primitive != primitive)
      rc_remember(scene, instance, primitive, triangle);
    float16 against;
    vertex->along = rc_meet_planes(rc_instance(scene, instance), &triangle->planes, rays, rc_bits16(live), &against);
    vertex->normal = rc_turned_to(triangle->normal, against);
    rc_store16((uint16)(triangle->surface), 0, vertex->surface);
    vertex->common = triangle->surface;
    return;
  }
  Vector16 v[3];
  uint16 surface = 0u;
  v[0].x = v[0].y = v[0].z = v[1].x = v[1].y = v[1].z = v[2].x = v[2].y = v[2].z = 0.0f;
  uint surfaces = 0, last = 0;
  for (uint left = live; left;) { /* neighbours share triangles */
    const uint primitive = primitive_of[rc_lowest(left)], lane = primitive % RC_BLOCK;
    const int16 same = (primitives == primitive) & rc_bits16(left);
    left &= ~rc_mask16(same);
    global const TriBlock* block = rc_block(scene, primitive / RC_BLOCK);
    global const float* at = (global const float*)block + lane;
#pragma unroll
    for (uint c = 0; c < 3u; ++c) {
      v[c].x = select(v[c].x, (float16)(at[48u * c]), same);
      v[c].y = select(v[c].y, (float16)(at[48u * c + 16u]), same);
      v[c].z = select(v[c].z, (float16)(at[48u * c + 32u]), same);
    }
    surfaces += surfaces == 0u || block->surface[lane] != last;
    last = block->surface[lane];
    surface = select(surface, (uint16)(last), same);
  }
  vertex->common = surfaces == 1u ? last : RC_NONE;
  rc_store16(surface, 0, vertex->surface);
  const Vector16 zero = {0.0f, 0.0f, 0.0f};
  const Planes16 planes = rc_planes16(v);
  vertex->along = 0.0f;
  vertex->normal = zero;
  if (RC_POINTS_OFF(t)) vertex->front = vertex->back = zero;
  while (live) { /* one instance after the other: its matrices are shared */
    const uint instance = instance_of[rc_lowest(live)];
    const int16 lanes = (instances == instance) & rc_bits16(live);
    live &= ~rc_mask16(lanes);
    global const Instance* placed = rc_instance(scene, instance);
    float16 against;
    const float16 along = rc_meet_planes(placed, &planes, rays, lanes, &against);
    vertex->along = select(vertex->along, along, lanes);
    vertex->normal =
        rc_select_vector16(vertex->normal, rc_turned_to(rc_unit_normals(placed, planes.normal), against), lanes);
    if (!RC_POINTS_OFF(t)) continue;
    Vector16 there, facing;
    float16 lift;
    const Vector16 from = rc_plus16(rays->origin, rays->offset);
    rc_surface_points(placed, v, from, rays->direction, &there, &facing, &lift);
    vertex->front = rc_select_vector16(vertex->front, there, lanes);
    if (!RC_HAS(t, PLATES) && !RC_HAS(t, LEAVES)) continue; /* nothing leaves a surface behind */
    const Vector16 backwards = {-rays->direction.x, -rays->direction.y, -rays->direction.z};
    rc_surface_points(placed, v, from, backwards, &there, &facing, &lift);
    vertex->back = rc_select_vector16(vertex->back, there, lanes);
  }
}

/* One factor of the lanes' surfaces at a line: reflectance, diffuse or straight transmittance, gloss (0 to 3). */
static inline float16 rc_matter16(const LidarTables* t, const Vertex16* vertex, uint line, uint which) {
  global const float* optics = (global const float*)t->optics;
  if (vertex->common != RC_NONE) return (float16)(optics[(vertex->common * RC_LINES(t) + line) * 4u + which]);
  RC_LINE float value[16];
  for (uint k = 0; k < 16u; ++k) value[k] = optics[(vertex->surface[k] * RC_LINES(t) + line) * 4u + which];
  return rc_load16(0, value);
}

/* Share of light that goes on into all directions, or mirrored. */
static inline float16 rc_scattered16(const LidarTables* t, const Vertex16* vertex, uint line) {
  float16 share = rc_matter16(t, vertex, line, 0) + rc_matter16(t, vertex, line, 1);
  if (RC_HAS(t, GLOSS)) share += rc_matter16(t, vertex, line, 3);
  return share;
}

#endif
