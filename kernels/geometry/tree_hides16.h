/* Whether sixteen rays from about one place meet a placed tree at all. A node that several of them meet is tested
 * against all of them at once; where few are left together, each goes on alone (tree_hides.h). Answers are those of
 * rc_tree_hides, ray by ray. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_TREE_HIDES16_H
#define RAYCUBE_KERNELS_GEOMETRY_TREE_HIDES16_H

#include "kernels/geometry/surface_point.h"
#include "kernels/geometry/tree_hides.h"

/* So many rays or fewer go on alone: a node costs all sixteen at once about what it costs so many one by one. Choice
 * changes time (2 to 5 are alike), never a result. Of rays that go one way, which share more, only the last (at 2 and
 * 4: 3 to 5 % longer). */
#define RC_FEW_RAYS 4u
#define RC_FEW_RAYS_ONE_WAY 1u

/* Rays in one frame. */
typedef struct Rays16 {
  float x[16], y[16], z[16];    /* origins, m */
  float dx[16], dy[16], dz[16]; /* directions */
} RC_LINE Rays16;

/* The same as box tests read them: a side at s is met at s * inverse + start. */
typedef struct BoxRays16 {
  float16 ix, iy, iz;
  float16 lo_x, lo_y, lo_z; /* starts of the lower sides */
  float16 hi_x, hi_y, hi_z; /* starts of the upper sides */
} BoxRays16;

/* Sixteen rays that all go one way, as triangles of a block are tried on them: origins in the plane of the ray's shear
 * (Ray::sx, sy), about `centre`. */
typedef struct OneWay16 {
  Ray ray;                     /* its direction and shear; the origin is not used */
  float4 centre;               /* m, frame of the tree */
  float x[16], y[16];          /* m */
  float across, along;         /* largest |x| or |y|, largest distance from the centre along the axis kz, m */
  uint near_x, near_y, near_z; /* floats into a node of the near sides (BoxRay) */
} OneWay16;

/* A node that waits, and the rays that meet it. */
typedef struct NodeOf16 {
  uint node;
  uint rays;
} NodeOf16;

static inline void rc_swap16(float16* a, float16* b) {
  const float16 kept = *a;
  *a = *b;
  *b = kept;
}

static inline float16 rc_safe_inverse16(float16 d) {
  return 1.0f / select(d, copysign((float16)(1e-18f), d), fabs(d) < 1e-18f);
}

/* One axis of rc_box_ray: the slack moves the near sides nearer and the far ones farther. */
static inline void rc_box_axis16(float16 origin, float16 slack, float16 inverse, float16* lo, float16* hi) {
  *lo = -inverse * (origin + slack);
  *hi = -inverse * (origin - slack);
}

static inline BoxRays16 rc_box_rays16(const Rays16* rays, float reach, float ulps) {
  BoxRays16 out;
  const float16 x = rc_load16(0, rays->x), y = rc_load16(0, rays->y), z = rc_load16(0, rays->z);
  const float16 slack = ulps * RC_ULP * (reach + rc_max16(fabs(x), rc_max16(fabs(y), fabs(z))));
  out.ix = rc_safe_inverse16(rc_load16(0, rays->dx));
  out.iy = rc_safe_inverse16(rc_load16(0, rays->dy));
  out.iz = rc_safe_inverse16(rc_load16(0, rays->dz));
  rc_box_axis16(x, slack, out.ix, &out.lo_x, &out.hi_x);
  rc_box_axis16(y, slack, out.iy, &out.lo_y, &out.hi_y);
  rc_box_axis16(z, slack, out.iz, &out.lo_z, &out.hi_z);
  return out;
}

/* Rays of 16 that meet child `slot` of a node. */
RC_ALWAYS static inline uint rc_box_met16(global const BvhNode* node, uint slot, const BoxRays16* r) {
  const float16 x0 = fma((float16)(node->lo_x[slot]), r->ix, r->lo_x),
                x1 = fma((float16)(node->hi_x[slot]), r->ix, r->hi_x);
  const float16 y0 = fma((float16)(node->lo_y[slot]), r->iy, r->lo_y),
                y1 = fma((float16)(node->hi_y[slot]), r->iy, r->hi_y);
  const float16 z0 = fma((float16)(node->lo_z[slot]), r->iz, r->lo_z),
                z1 = fma((float16)(node->hi_z[slot]), r->iz, r->hi_z);
  const float16 enter =
      rc_max16(rc_max16(rc_min16(x0, x1), rc_min16(y0, y1)), rc_max16(rc_min16(z0, z1), (float16)(0.0f)));
  const float16 leave = rc_min16(rc_min16(rc_max16(x0, x1), rc_max16(y0, y1)), rc_max16(z0, z1));
  return rc_mask16(enter <= leave);
}

/* The same of rays that go one way. r: starts of the near sides in lo_*, of the far ones in hi_*. */
RC_ALWAYS static inline uint rc_box_met_way(global const BvhNode* node, uint slot, const BoxRays16* r,
                                            const OneWay16* way) {
  global const float* at = (global const float*)node + slot;
  const float16 enter = rc_max16(
      rc_max16(fma((float16)(at[way->near_x]), r->ix, r->lo_x), fma((float16)(at[way->near_y]), r->iy, r->lo_y)),
      rc_max16(fma((float16)(at[way->near_z]), r->iz, r->lo_z), (float16)(0.0f)));
  const float16 leave = rc_min16(rc_min16(fma((float16)(at[24u - way->near_x]), r->ix, r->hi_x),
                                          fma((float16)(at[40u - way->near_y]), r->iy, r->hi_y)),
                                 fma((float16)(at[56u - way->near_z]), r->iz, r->hi_z));
  return rc_mask16(enter <= leave);
}

static inline void rc_put_ray(Rays16* rays, uint k, float4 origin, float4 direction) {
  rays->x[k] = origin.x;
  rays->y[k] = origin.y;
  rays->z[k] = origin.z;
  rays->dx[k] = direction.x;
  rays->dy[k] = direction.y;
  rays->dz[k] = direction.z;
}

static inline void rc_store_rays16(Vector16 origin, Vector16 direction, Rays16* rays) {
  rc_store16(origin.x, 0, rays->x);
  rc_store16(origin.y, 0, rays->y);
  rc_store16(origin.z, 0, rays->z);
  rc_store16(direction.x, 0, rays->dx);
  rc_store16(direction.y, 0, rays->dy);
  rc_store16(direction.z, 0, rays->dz);
}

static inline Ray rc_ray_of16(const Rays16* rays, uint k) {
  return rc_make_ray((float4)(rays->x[k], rays->y[k], rays->z[k], 0.0f),
                     (float4)(rays->dx[k], rays->dy[k], rays->dz[k], 0.0f));
}

/* Makes ready for rays that go one way, of which the first is `first`: their places across the way, and near sides in
 * place of lower ones. */
static inline void rc_one_way16(const Rays16* rays, Ray first, BoxRays16* boxes, OneWay16* way) {
  const float16 at[3] = {rc_load16(0, rays->x), rc_load16(0, rays->y), rc_load16(0, rays->z)};
  way->ray = first;
  way->centre = first.origin;
  const float16 z = at[first.kz] - rc_component(first.origin, first.kz);
  const float16 x = fma((float16)(-first.sx), z, at[first.kx] - rc_component(first.origin, first.kx));
  const float16 y = fma((float16)(-first.sy), z, at[first.ky] - rc_component(first.origin, first.ky));
  rc_store16(x, 0, way->x);
  rc_store16(y, 0, way->y);
  way->across = rc_most16(rc_max16(fabs(x), fabs(y)));
  way->along = rc_most16(fabs(z));
  way->near_x = first.inverse.x < 0.0f ? 24u : 0u;
  way->near_y = first.inverse.y < 0.0f ? 32u : 8u;
  way->near_z = first.inverse.z < 0.0f ? 40u : 16u;
  if (way->near_x) rc_swap16(&boxes->lo_x, &boxes->hi_x);
  if (way->near_y > 8u) rc_swap16(&boxes->lo_y, &boxes->hi_y);
  if (way->near_z > 16u) rc_swap16(&boxes->lo_z, &boxes->hi_z);
}

/* Of `met`, rays that go one way, those that a triangle of a block hides. The triangles' edges are linear forms of a
 * ray's place across the way, good to a few rounding errors; a ray that these may let in is asked by the single-ray
 * test, whose answer counts.
 * Errors: a coordinate across the way is off by 4 ulp of the distances that went into it, here and in the single-ray
 * test (difference 1, its shear 1, sum 1, and 1 for the ray's place), so by `off` together; an edge's form, a sum of
 * products of two such, by 8 off times the largest of them, the products' own rounding included. */
static inline uint rc_block_hides_way(const OneWay16* way, const Rays16* rays, uint met, global const TriBlock* block) {
  global const float* at = (global const float*)block;
  const Ray ray = way->ray;
  const uint kx = 16u * (uint)ray.kx, ky = 16u * (uint)ray.ky, kz = 16u * (uint)ray.kz;
  const float16 ox = rc_component(way->centre, ray.kx), oy = rc_component(way->centre, ray.ky),
                oz = rc_component(way->centre, ray.kz), sx = -ray.sx, sy = -ray.sy;
  const float16 az = rc_load16(0, at + kz) - oz, bz = rc_load16(0, at + 48 + kz) - oz,
                cz = rc_load16(0, at + 96 + kz) - oz;
  const float16 ax = fma(sx, az, rc_load16(0, at + kx) - ox), ay = fma(sy, az, rc_load16(0, at + ky) - oy);
  const float16 bx = fma(sx, bz, rc_load16(0, at + 48 + kx) - ox), by = fma(sy, bz, rc_load16(0, at + 48 + ky) - oy);
  const float16 cx = fma(sx, cz, rc_load16(0, at + 96 + kx) - ox), cy = fma(sy, cz, rc_load16(0, at + 96 + ky) - oy);
  const float16 across = way->across + rc_max16(rc_max16(rc_max16(fabs(ax), fabs(ay)), rc_max16(fabs(bx), fabs(by))),
                                                rc_max16(fabs(cx), fabs(cy)));
  const float16 along = way->along + rc_max16(rc_max16(fabs(az), fabs(bz)), fabs(cz));
  const float16 off = 8.0f * RC_ULP * (2.0f * along + across), slack = 8.0f * off * across;
  const float16 u0 = cx * by - cy * bx, ux = cy - by, uy = bx - cx;
  const float16 v0 = ax * cy - ay * cx, vx = ay - cy, vy = cx - ax;
  const float16 w0 = bx * ay - by * ax, wx = by - ay, wy = ax - bx;
  uint hidden = 0;
  for (; met; met &= met - 1u) {
    const uint k = rc_lowest(met);
    const float16 x = way->x[k], y = way->y[k];
    const float16 u = fma(x, ux, fma(y, uy, u0)), v = fma(x, vx, fma(y, vy, v0)), w = fma(x, wx, fma(y, wy, w0));
    const float16 least = rc_min16(u, rc_min16(v, w)), most = rc_max16(u, rc_max16(v, w));
    if (!rc_mask16((least >= -slack) | (most <= slack))) continue;
    Ray one = ray;
    one.origin = (float4)(rays->x[k], rays->y[k], rays->z[k], 0.0f);
    float16 t;
    if (rc_hit_block(one, false, block, &t)) hidden |= 1u << k;
  }
  return hidden;
}

/* Of `live`, the rays (in the tree's frame) that a placed tree hides. one_way: they all have one direction. */
RC_ALWAYS static inline uint rc_tree_hides16(SceneArrays scene, uint root, const Rays16* rays, uint live,
                                             bool one_way) {
  const float reach = rc_node(scene, root)->reach;
  BoxRays16 boxes = rc_box_rays16(rays, reach, RC_MESH_SLACK);
  OneWay16 way;
  if (one_way) rc_one_way16(rays, rc_ray_of16(rays, 0), &boxes, &way);
  uint alone[RC_STACK + RC_STACK_SPARE];
  alone[0] = 0;
  NodeOf16 stack[RC_STACK];
  Ray made[16];
  uint ready = 0, hidden = 0, top = 1;
  stack[0].node = root;
  stack[0].rays = live;
  while (top) {
    const NodeOf16 at = stack[--top];
    uint left = at.rays & ~hidden;
    if (!left) continue;
    if (popcount(left) <= (one_way ? RC_FEW_RAYS_ONE_WAY : RC_FEW_RAYS)) {
      for (; left; left &= left - 1u) {
        const uint k = rc_lowest(left);
        if (!(ready >> k & 1u)) made[k] = rc_ray_of16(rays, k);
        ready |= 1u << k;
        const BoxRay box = rc_box_ray(made[k], reach, RC_MESH_SLACK);
        if (rc_tree_hides_from(scene, at.node, made[k], &box, INFINITY, alone, 1u)) hidden |= 1u << k;
      }
      continue;
    }
    global const BvhNode* node = rc_node(scene, at.node);
    for (uint slot = 0; slot < node->count; ++slot) {
      uint met = (one_way ? rc_box_met_way(node, slot, &boxes, &way) : rc_box_met16(node, slot, &boxes)) & left;
      if (!met) continue;
      if (!(node->leaf_mask >> slot & 1u)) {
        stack[top].node = node->child[slot];
        stack[top].rays = met;
        ++top;
        continue;
      }
      met &= ~hidden;
      if (one_way) {
        if (met) hidden |= rc_block_hides_way(&way, rays, met, rc_block(scene, node->child[slot]));
        continue;
      }
      for (; met; met &= met - 1u) {
        const uint k = rc_lowest(met);
        if (!(ready >> k & 1u)) made[k] = rc_ray_of16(rays, k);
        ready |= 1u << k;
        float16 t;
        if (rc_hit_block(made[k], false, rc_block(scene, node->child[slot]), &t)) hidden |= 1u << k;
      }
    }
  }
  return hidden;
}

#endif
