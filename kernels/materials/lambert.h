/* Lambert's law: the same radiance into every direction of the side that light came from. */
#ifdef RC_SHAPE
RC_SHAPE(lambert, front, 1, 1, "The same radiance into all directions.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_LAMBERT_H)
#define RAYCUBE_KERNELS_MATERIALS_LAMBERT_H

#include "kernels/materials/angles.h"

static inline rc_real rc_lambert_eval(rc_real scale, RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_in > 0 && a.cos_out > 0 ? scale * RC_INVERSE_PI : 0;
}
static inline RcLocal rc_lambert_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  (void)p, (void)in;
  return rc_cosine_law(u, v);
}
static inline rc_real rc_lambert_pdf(RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_out > 0 ? a.cos_out * RC_INVERSE_PI : 0;
}

#endif
