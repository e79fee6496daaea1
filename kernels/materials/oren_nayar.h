/* Rough matter whose facets are Lambertian: Oren & Nayar, "Generalization of Lambert's Reflectance Model", SIGGRAPH
 * 1994, with the ratio of direct to shadowed terms of their fit (eq. 30) and Fujii's form of the angles, "A tiny
 * improvement of Oren-Nayar reflectance model" (2012), which gives back no more than it gets (eq. 30 up to 1.4 % more
 * near the horizon). p[0]: standard deviation of the facets' slope, degrees. */
#ifdef RC_SHAPE
RC_SHAPE(oren_nayar, front, 1, 1,
         "Lambertian facets of random slope: brighter towards the sun, flatter over the angle of incidence.")
RC_SHAPE_TABLE(oren_nayar, "Rough reflectance, brighter towards where light comes from.",
               "Oren & Nayar (1994) in Fujii's form (2012): Lambertian facets, pi f = A (1 + r s / t).")
RC_SHAPE_PARAMETER(oren_nayar, 0, "sigma_deg", "deg", "0", "90",
                   "Standard deviation of the facets' slope angle; 0: Lambert's law.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_OREN_NAYAR_H)
#define RAYCUBE_KERNELS_MATERIALS_OREN_NAYAR_H

#include "kernels/materials/angles.h"

static inline rc_real rc_oren_nayar_eval(rc_real scale, RcParameters p, RcAngles a) {
  const rc_real sigma = p.of[0] * RC_REAL(0.017453292519943296), s2 = sigma * sigma;
  const rc_real r =
      RC_REAL(0.45) * s2 / (s2 + RC_REAL(0.09)) / (RC_REAL(1.0) - RC_REAL(0.5) * s2 / (s2 + RC_REAL(0.33)));
  const rc_real t = a.along > 0 ? fmax(a.cos_in, a.cos_out) : RC_REAL(1.0);
  if (!(a.cos_in > 0 && a.cos_out > 0)) return 0;
  /* 1/2 - 2 / (3 pi): the second term's share of a hemisphere. */
  return scale * RC_INVERSE_PI * (RC_REAL(1.0) + r * a.along / t) / (RC_REAL(1.0) + RC_REAL(0.28779341) * r);
}
static inline RcLocal rc_oren_nayar_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  (void)p, (void)in;
  return rc_cosine_law(u, v);
}
static inline rc_real rc_oren_nayar_pdf(RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_out > 0 ? a.cos_out * RC_INVERSE_PI : 0;
}

#endif
