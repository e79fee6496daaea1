/* GGX gloss for pulses. At zero phase what the laser lights is what the receiver sees: masking enters once. */
#ifndef RAYCUBE_KERNELS_LIDAR_GLOSS_H
#define RAYCUBE_KERNELS_LIDAR_GLOSS_H

#include "kernels/lidar/context.h"

#if RC_GLOSS
/* Smith's Lambda of GGX: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007. */
static inline float rc_smith(float alpha, float cosine) {
  const float square = fmax(1.0f - cosine * cosine, 0.0f) / (cosine * cosine);
  return 0.5f * (sqrt(fma(alpha * alpha, square, 1.0f)) - 1.0f);
}

/* BRDF, 1/sr, of a surface's glossy materials; in, out: unit, away from the surface, both above it. Masking and
 * shadowing are joined by the angle between the two ways' azimuths (van Ginneken et al. 1998; Heitz, "Understanding the
 * Masking-Shadowing Function", JCGT 3(2), 2014, eq. 96): 1 / (1 + max Lambda + m min Lambda), m = 4.41 phi / (4.41 phi
 * + 1): G1 at zero phase. */
static inline float rc_gloss(const LidarTables* t, uint surface, float4 normal, float4 in, float4 out) {
  const float cos_in = dot(normal, in), cos_out = dot(normal, out);
  if (!(cos_in > 1e-4f && cos_out > 1e-4f)) return 0.0f;
  const float4 half_way = normalize(in + out);
  const float cos_half = fmin(dot(normal, half_way), 1.0f), cos_turn = clamp(dot(in, half_way), 0.0f, 1.0f);
  const float4 flat_in = in - cos_in * normal, flat_out = out - cos_out * normal;
  const float sizes = sqrt(dot(flat_in, flat_in) * dot(flat_out, flat_out));
  const float4 turn = cross(flat_in, flat_out);
  const float phi = sizes > 0.0f ? atan2(sqrt(dot(turn, turn)), dot(flat_in, flat_out)) : 0.0f,
              join = 4.41f * phi / fma(4.41f, phi, 1.0f);
  const float bent = 1.0f - cos_turn, schlick = bent * bent * bent * bent * bent;
  float sum = 0.0f;
  for (uint i = 0; i < 4u; ++i) {
    const float f0 = t->gloss[surface * 12u + 3u * i], alpha = t->gloss[surface * 12u + 3u * i + 1u],
                share = t->gloss[surface * 12u + 3u * i + 2u];
    if (!(share > 0.0f)) continue;
    const float a2 = alpha * alpha, below = fma(cos_half * cos_half, a2 - 1.0f, 1.0f);
    const float spread = a2 * 0.318309886f / (below * below), x = rc_smith(alpha, cos_in), y = rc_smith(alpha, cos_out);
    const float masking = 1.0f / (1.0f + fmax(x, y) + join * fmin(x, y));
    sum += share * fma(1.0f - f0, schlick, f0) * spread * masking / (4.0f * cos_in * cos_out);
  }
  return sum;
}
#endif

#endif
