/* The draws by which a side of a sample's surface finds a lamp, and a point of it. Valid C++20 and OpenCL C 1.2: host
 * and device have the same bits. */
#ifndef RAYCUBE_KERNELS_SAMPLING_LAMP_DRAWS_H
#define RAYCUBE_KERNELS_SAMPLING_LAMP_DRAWS_H

#include "kernels/sampling/sampler.h"

#define RC_LAMP_DIMENSION 33u /* of rc_hash */

/* Where a sample of nu x nv stands among all of its pixel's draws: those of each of the parts whose spread tells the
 * standard error (rc_sky_shares) follow one another, so that a part is as even as so few draws can be. kind:
 * RC_SAMPLER_*. */
RC_INLINE rc_u32 rc_lamp_number(int kind, rc_u32 nu, rc_u32 nv, rc_u32 sample) {
  if (kind == RC_SAMPLER_LATTICE || nu < 2u || nv < 2u) return sample % 4u * ((nu * nv + 3u) / 4u) + sample / 4u;
  const rc_u32 column = sample % nu, row = sample / nu, wide = (nu + 1u) / 2u;
  return (column % 2u + row % 2u * 2u) * (wide * ((nv + 1u) / 2u)) + row / 2u * wide + column / 2u;
}

/* Draw `number` of a side (RC_NEAR_SIDE ...) of a pixel's samples among the lamps of a source: which lamp follows the
 * golden section, which point of it the R2 sequence (Roberts 2018); each side and source has a start of its own. */
RC_INLINE void rc_lamp_draws(rc_u32 seed, rc_u32 pixel, rc_u32 source, rc_u32 side, rc_u32 number, float* u, float* v,
                             float* w) {
  const rc_u32 start = 9u * source + 3u * side;
  *u = rc_unit_float(rc_hash(seed, pixel, start, RC_LAMP_DIMENSION) + (number + 1u) * 2654435769u);
  *v = rc_unit_float(rc_hash(seed, pixel, start + 1u, RC_LAMP_DIMENSION) + (number + 1u) * 3242174889u);
  *w = rc_unit_float(rc_hash(seed, pixel, start + 2u, RC_LAMP_DIMENSION) + (number + 1u) * 2447445414u);
}

#endif
