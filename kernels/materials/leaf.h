/* A leaf: what it transmits leaves by its other side, with the same radiance into every direction there. Frames and
 * angles: `out` to the far side, its cosine negative. */
#ifdef RC_SHAPE
RC_SHAPE(leaf, behind, 1, 1, "Transmitted light leaves by the other side, the same radiance into all directions.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_LEAF_H)
#define RAYCUBE_KERNELS_MATERIALS_LEAF_H

#include "kernels/materials/angles.h"

static inline rc_real rc_leaf_eval(rc_real scale, RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_in * a.cos_out < 0 ? scale * RC_INVERSE_PI : 0;
}
static inline RcLocal rc_leaf_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  (void)p, (void)in;
  return rc_cosine_law(u, v);
}
static inline rc_real rc_leaf_pdf(RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_in * a.cos_out < 0 ? fabs(a.cos_out) * RC_INVERSE_PI : 0;
}

#endif
