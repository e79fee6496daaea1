/* How surfaces spread what they reflect: shapes of kernels/materials at the vertices of pulses. */
#ifndef RAYCUBE_KERNELS_LIDAR_LOBES_H
#define RAYCUBE_KERNELS_LIDAR_LOBES_H

#include "kernels/lidar/context.h"
#include "kernels/materials/shapes.h"

/* Where a line's lobes lie, and what was found of them: all lines may share those of the first. */
static inline uint rc_lobe_line(const LidarTables* t, uint line) { return RC_LOBE_LINES(t) > 1u ? line : 0u; }

static inline global const Lobe* rc_first_lobe(const LidarTables* t, uint surface, uint line) {
  return t->lobes + (surface * RC_LOBE_LINES(t) + rc_lobe_line(t, line)) * t->lobe_stride;
}

/* Sum of a surface's further lobes of one role, 1/sr, `scale` times. */
static inline float rc_further(const LidarTables* t, global const Lobe* first, uint role, float scale,
                               RcAngles angles) {
  float sum = 0.0f;
  for (uint i = RC_LOBES; i < t->lobe_stride; ++i) {
    const Lobe lobe = first[i];
    if (lobe.share == 0.0f || rc_shape_role(lobe.shape) != role) continue;
    sum += rc_shape_eval(lobe.shape, scale * lobe.share, rc_parameters(t->lobes, lobe), angles);
  }
  return sum;
}

/* 1/sr per unit of a surface's reflectance of a line, `scale` times. */
static inline float rc_front(const LidarTables* t, uint surface, uint line, float scale, RcAngles angles) {
  global const Lobe* first = rc_first_lobe(t, surface, line);
  const Lobe lobe = *first;
  return rc_shape_eval(lobe.shape, scale * lobe.share, rc_parameters(t->lobes, lobe), angles) +
         rc_further(t, first, RC_ROLE_front, scale, angles);
}

/* BRDF, 1/sr, of a surface's glossy materials. */
static inline float rc_gloss(const LidarTables* t, uint surface, uint line, RcAngles angles) {
  global const Lobe* first = rc_first_lobe(t, surface, line);
  float sum = rc_further(t, first, RC_ROLE_gloss, 1.0f, angles);
  for (uint i = 1; i < RC_LOBE_BEHIND; ++i) {
    const Lobe lobe = first[i];
    if (!(lobe.share > 0.0f)) continue;
    sum += rc_shape_eval(lobe.shape, lobe.share, rc_parameters(t->lobes, lobe), angles);
  }
  return sum;
}

/* alpha of the facets by which paths look for light that a surface's gloss sends on: the roughest of its lobes. */
static inline float rc_gloss_alpha(const LidarTables* t, uint surface) {
  global const Lobe* first = rc_first_lobe(t, surface, 0u);
  float alpha = 0.0f;
  for (uint i = 0; i < t->lobe_stride; ++i) {
    const Lobe lobe = first[i];
    alpha = fmax(alpha, rc_shape_roughness(lobe.shape, rc_parameters(t->lobes, lobe)));
  }
  return alpha;
}

/* A frame about a unit normal: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017. */
typedef struct Frame {
  float4 t, b, n;
} Frame;
static inline Frame rc_frame(float4 n) {
  const float s = copysign(1.0f, n.z), a = -1.0f / (s + n.z), c = n.x * n.y * a;
  const Frame f = {(float4)(fma(s * n.x * a, n.x, 1.0f), s * c, -s * n.x, 0.0f),
                   (float4)(c, fma(n.y * a, n.y, s), -n.y, 0.0f), n};
  return f;
}
static inline float4 rc_from_frame(Frame f, RcLocal v) { return v.x * f.t + v.y * f.b + v.z * f.n; }
static inline RcLocal rc_to_frame(Frame f, float4 v) {
  const RcLocal r = {dot(v, f.t), dot(v, f.b), dot(v, f.n)};
  return r;
}

#endif
