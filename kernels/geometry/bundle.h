/* What bundles of rays share: culling planes against the boxes of a node, and 16 triangles set up at once as linear
 * functions of a plane's coordinates (a, b). The plane is the image plane for primary rays (perspective) and the plane
 * across the sun or sky direction for shadow rays (parallel).
 *
 * Exactness. In floats, a barycentric coordinate l(a, b) near zero has an uncertain sign. Every triangle carries a
 * bound of that error; a sample beyond it is decided, a sample inside it is decided by the single-ray test of
 * triangle.h, with the very ray that a single ray would be. All decisions on a triangle are therefore those of the
 * watertight single-ray test, whatever the bundle. Which of two surfaces is nearer is told by the interpolated nearness
 * (primary_frame.h) where both are sure: only surfaces closer than its rounding may change places. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_BUNDLE_H
#define RAYCUBE_KERNELS_GEOMETRY_BUNDLE_H

#include "kernels/geometry/scene_arrays.h"
#include "kernels/geometry/surface_point.h"
#include "kernels/geometry/triangle.h"

#define RC_MAX_PLANES 5

/* A point p of the frame belongs to the region when n . (p - origin) + k >= 0 for every plane (n, k). */
typedef struct Cull {
  float ox, oy, oz;
  float nx[RC_MAX_PLANES], ny[RC_MAX_PLANES], nz[RC_MAX_PLANES], k[RC_MAX_PLANES];
  uint x_side[RC_MAX_PLANES], y_side[RC_MAX_PLANES],
      z_side[RC_MAX_PLANES]; /* floats from a node's start to the corner that n points to */
} Cull;

static inline void rc_set_plane(Cull* cull, int i, float4 n, float k) {
  cull->nx[i] = n.x;
  cull->ny[i] = n.y;
  cull->nz[i] = n.z;
  cull->k[i] = k;
  cull->x_side[i] = n.x > 0.0f ? 24u : 0u;
  cull->y_side[i] = n.y > 0.0f ? 32u : 8u;
  cull->z_side[i] = n.z > 0.0f ? 40u : 16u;
}

/* Bit i: box i of the node meets the region, or rounding cannot tell. A box with a point p inside the region has its
 * corner further along n, so the rounding of the sum is covered by rounding at p, which the region's slack holds. */
RC_ALWAYS static inline uint rc_cull_boxes(const Cull* cull, int planes, global const BvhNode* node) {
  global const float* at = (global const float*)node;
  float8 least = INFINITY;
#pragma unroll
  for (int i = 0; i < planes; ++i) {
    const float8 x = vload8(0, at + cull->x_side[i]) - cull->ox;
    const float8 y = vload8(0, at + cull->y_side[i]) - cull->oy;
    const float8 z = vload8(0, at + cull->z_side[i]) - cull->oz;
    least = rc_min8(least, fma(x, (float8)(cull->nx[i]),
                               fma(y, (float8)(cull->ny[i]), fma(z, (float8)(cull->nz[i]), (float8)(cull->k[i])))));
  }
  return rc_mask8(least >= 0.0f) & ((1u << node->count) - 1u);
}

/* A map from a frame to plane coordinates: rows applied to p - origin. Perspective: the distance is z = ahead + its
 * row. */
typedef struct Projection {
  float4 origin, a, b, z;
  float ahead;
  /* nearness: (near_0 + near_1 (z - ahead)) / z, rc_set_nearness;
   * near_slack: its error for surfaces far from edge-on */
  float near_0, near_1, near_slack;
  /* with m = max(|a|, |b|): error + error_growth m + error_square m^2, in plane units */
  float error, error_growth, error_square;
} Projection;

/* 16 triangles over the plane: l1 = l1a a + l1b b + l1c, l2 likewise, l0 = 1 - l1 - l2, and a depth q = q0 + l1 q1 + l2
 * q2. */
typedef struct Setup {
  float16 l1a, l1b, l1c, l2a, l2b, l2c, q0, q1, q2;
  float16 error; /* of the vertices' plane coordinates */
  float16 band;  /* |l| up to this is uncertain; 2: the triangle is edge-on, every sample is uncertain */
  float16 lo_a, hi_a, lo_b, hi_b; /* rectangle, grown by its error */
  int16 usable; /* -1: the linear form holds; 0: degenerate, or some vertex behind or far beside the plane */
  int16 behind; /* -1 (perspective, not usable): must be tested ray by ray */
} Setup;

static inline float16 rc_project_row(float4 row, float16 x, float16 y, float16 z) {
  return fma((float16)(row.x), x, fma((float16)(row.y), y, (float16)(row.z) * z));
}

/* perspective: a and b are divided by z and the depth is the nearness; else the depth is z. */
RC_ALWAYS static inline Setup rc_setup_block(const Projection* map, global const TriBlock* block, bool perspective) {
  global const float* at = (global const float*)block;
  float16 a[3], b[3], q[3];
  int16 front = -1;
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    const float16 x = rc_load16(0, at + 48 * i) - map->origin.x, y = rc_load16(0, at + 48 * i + 16) - map->origin.y;
    const float16 z = rc_load16(0, at + 48 * i + 32) - map->origin.z;
    a[i] = rc_project_row(map->a, x, y, z);
    b[i] = rc_project_row(map->b, x, y, z);
    q[i] = rc_project_row(map->z, x, y, z);
    if (perspective) {
      const float16 distance = q[i] + map->ahead, inverse = 1.0f / distance;
      front &= distance > 0.0f;
      a[i] *= inverse;
      b[i] *= inverse;
      q[i] = fma((float16)(map->near_1), q[i], (float16)(map->near_0)) * inverse;
    }
  }
  Setup s;
  const float16 lo_a = rc_min16(a[0], rc_min16(a[1], a[2])), hi_a = rc_max16(a[0], rc_max16(a[1], a[2]));
  const float16 lo_b = rc_min16(b[0], rc_min16(b[1], b[2])), hi_b = rc_max16(b[0], rc_max16(b[1], b[2]));
  float16 largest = rc_max16(rc_max16(hi_a, -lo_a), rc_max16(hi_b, -lo_b));
  if (!perspective) largest = rc_max16(largest, rc_max16(fabs(q[0]), rc_max16(fabs(q[1]), fabs(q[2]))));
  const float16 error =
      fma(fma((float16)(map->error_square), largest, (float16)(map->error_growth)), largest, (float16)(map->error));
  s.error = error;
  s.lo_a = lo_a - error;
  s.hi_a = hi_a + error;
  s.lo_b = lo_b - error;
  s.hi_b = hi_b + error;
  const float16 extent = (hi_a - lo_a) + (hi_b - lo_b);
  const float16 a1 = a[1] - a[0], b1 = b[1] - b[0], a2 = a[2] - a[0], b2 = b[2] - b[0];
  const float16 det = a1 * b2 - b1 * a2;
  /* Each coordinate is off by at most `error`: an edge function (two differences times two lengths inside the
   * rectangle, one vertex times the edge) by 3 error extent; its own rounding is inside error_growth. */
  const float16 edge_error = 3.0f * error * extent;
  const int16 edge_on = fabs(det) <= 3.0f * edge_error;
  const float16 r = select(1.0f / det, (float16)(0.0f), edge_on);
  s.l1a = b2 * r;
  s.l1b = -a2 * r;
  s.l1c = -fma(a[0], s.l1a, b[0] * s.l1b);
  s.l2a = -b1 * r;
  s.l2b = a1 * r;
  s.l2c = -fma(a[0], s.l2a, b[0] * s.l2b);
  s.band = select(edge_error * fabs(r), (float16)(2.0f), edge_on);
  s.q0 = q[0];
  s.q1 = q[1] - q[0];
  s.q2 = q[2] - q[0];
  s.usable = extent > 0.0f;
  s.behind = 0;
  if (perspective) {
    const int16 holds = front & (error < fma((float16)(0.01f), largest, (float16)(0.1f)));
    s.usable &= holds;
    s.behind = ~holds;
  }
  return s;
}

/* The linear forms lane by lane, for loops whose lanes are samples. */
typedef struct LaneForms {
  float l1a[16], l1b[16], l1c[16], l2a[16], l2b[16], l2c[16], q0[16], q1[16], q2[16], band[16];
} RC_LINE LaneForms;

/* The rectangles likewise. */
typedef struct LaneRectangles {
  float lo_a[16], hi_a[16], lo_b[16], hi_b[16];
} RC_LINE LaneRectangles;

static inline void rc_store_forms(const Setup* s, LaneForms* to) {
  rc_store16(s->l1a, 0, to->l1a);
  rc_store16(s->l1b, 0, to->l1b);
  rc_store16(s->l1c, 0, to->l1c);
  rc_store16(s->l2a, 0, to->l2a);
  rc_store16(s->l2b, 0, to->l2b);
  rc_store16(s->l2c, 0, to->l2c);
  rc_store16(s->q0, 0, to->q0);
  rc_store16(s->q1, 0, to->q1);
  rc_store16(s->q2, 0, to->q2);
  rc_store16(s->band, 0, to->band);
}

static inline void rc_store_rectangles(const Setup* s, LaneRectangles* to) {
  rc_store16(s->lo_a, 0, to->lo_a);
  rc_store16(s->hi_a, 0, to->hi_a);
  rc_store16(s->lo_b, 0, to->lo_b);
  rc_store16(s->hi_b, 0, to->hi_b);
}

/* Pushes the children of a node that meet the region and returns the new height of the stack. Leaves carry RC_LEAF:
 * blocks in a placed tree, instances in the top tree. */
RC_ALWAYS static inline uint rc_push_children(const Cull* cull, int planes, SceneArrays scene, uint index, bool in_mesh,
                                              uint* stack, uint top) {
  global const BvhNode* node = rc_node(scene, index);
  const uint leaves = node->leaf_mask;
  for (uint boxes = rc_cull_boxes(cull, planes, node); boxes; boxes &= boxes - 1u) {
    const uint slot = rc_lowest(boxes), child = node->child[slot];
    const bool leaf = leaves >> slot & 1u;
    if (!leaf)
      rc_prefetch(rc_node(scene, child), 256);
    else if (in_mesh)
      rc_prefetch(rc_block(scene, child), 576);
    stack[top++] = leaf ? child | RC_LEAF : child;
  }
  return top;
}

#endif
