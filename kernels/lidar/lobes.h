/* How surfaces spread what they reflect: shapes of kernels/materials at the vertices of pulses. */
#ifndef RAYCUBE_KERNELS_LIDAR_LOBES_H
#define RAYCUBE_KERNELS_LIDAR_LOBES_H

#include "kernels/lidar/context.h"
#include "kernels/materials/shapes.h"

/* 1/sr per unit of the reflectance curve. */
static inline float rc_front(const LidarTables* t, uint surface, RcAngles angles) {
  const Lobe lobe = t->lobes[surface * RC_LOBE_STRIDE];
  return rc_shape_eval(lobe.shape, 1.0f, rc_parameters(lobe.parameter), angles);
}

/* BRDF, 1/sr, of a surface's glossy materials. */
static inline float rc_gloss(const LidarTables* t, uint surface, RcAngles angles) {
  float sum = 0.0f;
  for (uint i = 1; i < RC_LOBE_BEHIND; ++i) {
    const Lobe lobe = t->lobes[surface * RC_LOBE_STRIDE + i];
    if (!(lobe.share > 0.0f)) continue;
    sum += rc_shape_eval(lobe.shape, lobe.share, rc_parameters(lobe.parameter), angles);
  }
  return sum;
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
