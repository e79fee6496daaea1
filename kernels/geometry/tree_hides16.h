/* Whether sixteen rays from about one place meet a placed tree at all. A node that several of them meet is tested
 * against all of them at once; where few are left together, each goes on alone (tree_hides.h). Answers are those of
 * rc_tree_hides, ray by ray. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_TREE_HIDES16_H
#define RAYCUBE_KERNELS_GEOMETRY_TREE_HIDES16_H

#include "kernels/geometry/surface_point.h"
#include "kernels/geometry/tree_hides.h"

/* So many rays or fewer go on alone: a node costs all sixteen at once about what it costs so many one by one. Choice
 * changes time (2 to 5 are alike), never a result. */
#define RC_FEW_RAYS 4u

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

/* A node that waits, and the rays that meet it. */
typedef struct NodeOf16 {
  uint node;
  uint rays;
} NodeOf16;

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

/* Of `live`, the rays (in the tree's frame) that a placed tree hides. */
static inline uint rc_tree_hides16(SceneArrays scene, uint root, const Rays16* rays, uint live) {
  const float reach = rc_node(scene, root)->reach;
  const BoxRays16 boxes = rc_box_rays16(rays, reach, RC_MESH_SLACK);
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
    if (popcount(left) <= RC_FEW_RAYS) {
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
      uint met = rc_box_met16(node, slot, &boxes) & left;
      if (!met) continue;
      if (!(node->leaf_mask >> slot & 1u)) {
        stack[top].node = node->child[slot];
        stack[top].rays = met;
        ++top;
        continue;
      }
      for (met &= ~hidden; met; met &= met - 1u) {
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
