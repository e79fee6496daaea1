/* Light of a group's samples ray by ray (RC_BUNDLE 0): what bundles must give, bit by bit. */
#ifndef RAYCUBE_KERNELS_LIGHT_LIGHT_RAYS_H
#define RAYCUBE_KERNELS_LIGHT_LIGHT_RAYS_H

#include "kernels/geometry/ray_trace.h"
#include "kernels/light/light_points.h"

/* Sends a sample's rays in the directions of its part of one set. Returns whether any of them is open. hidden:
 * what the blocked ones would have sent, by component. */
static inline bool rc_light_of_sample(SceneArrays scene, global const float* at, global const float4* directions,
                                      global const float4* weights, uint sky, uint count, uint share, uint part,
                                      float4* hidden) {
  const float4 normal = (float4)(at[RC_PLANE(RC_NORMAL_X)], at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)], 0.0f);
  const float4 point = (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
  bool lit = false;
  for (uint quad = 0; quad < RC_SKY_QUADS; ++quad) hidden[quad] = (float4)(0.0f);
  for (uint j = 0; j < count / share; ++j) {
    const uint m = rc_sky_direction(part, j, share);
    const float4 direction = directions[m];
    const float cosine = fma(direction.x, normal.x, fma(direction.y, normal.y, direction.z * normal.z));
    if (!(cosine > 0.0f)) continue;
    const bool open = rc_trace_ray(scene, point, direction, true).instance == RC_NONE;
    if (sky && !open)
      for (uint quad = 0; quad < RC_SKY_QUADS; ++quad)
        hidden[quad] = fma(weights[m * RC_SKY_QUADS + quad], (float4)(cosine * (float)share), hidden[quad]);
#if RC_SHAPED
    if (sky && open) {
      const float missing = cosine * (float)share * (1.0f - rc_spread(at, direction));
      for (uint quad = 0; quad < RC_SKY_QUADS; ++quad)
        hidden[quad] = fma(weights[m * RC_SKY_QUADS + quad], (float4)(missing), hidden[quad]);
    }
#endif
    lit |= open;
  }
  return lit;
}

/* Files what is hidden from the sample of one slot. */
static inline void rc_write_hidden(const float4* hidden, global float* blocked) {
  for (uint quad = 0; quad < RC_SKY_QUADS; ++quad) {
    global float* to = blocked + RC_PLANE(4 * quad);
    to[0] = hidden[quad].x;
    to[RC_PLANE(1)] = hidden[quad].y;
    to[RC_PLANE(2)] = hidden[quad].z;
    to[RC_PLANE(3)] = hidden[quad].w;
  }
}

#endif
