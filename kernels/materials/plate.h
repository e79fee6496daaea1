/* A plate: what it transmits goes straight on. Its shape is a peak without width, so there is nothing to evaluate
 * towards a direction of another's choice, and no density: paths that take it multiply by the transmittance alone. */
#ifdef RC_SHAPE
RC_SHAPE(plate, behind, 1, 1, "Transmitted light goes straight on.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_PLATE_H)
#define RAYCUBE_KERNELS_MATERIALS_PLATE_H

#include "kernels/materials/angles.h"

static inline rc_real rc_plate_eval(rc_real scale, RcParameters p, RcAngles a) {
  (void)scale, (void)p, (void)a;
  return 0;
}
/* The frame's z is the normal of the far side, where light comes from has z < 0. */
static inline RcLocal rc_plate_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  RcLocal out;
  (void)p, (void)u, (void)v;
  out.x = -in.x;
  out.y = -in.y;
  out.z = -in.z;
  return out;
}
static inline rc_real rc_plate_pdf(RcParameters p, RcAngles a) {
  (void)p, (void)a;
  return 0;
}

#endif
