/* The simplified specular lobe of paints and older models: Phong's cosine power about the mirrored way, made reciprocal
 * and bounded by Lafortune & Willems, "Using the Modified Phong Reflectance Model for Physically Based Rendering",
 * Report CW 197, K.U. Leuven 1994 (equation 8): f = r (n + 2) / (2 pi) cos^n of the angle to the mirrored way.
 * p[0]: n; p[1]: r, what it mirrors at normal incidence, at others less. */
#ifdef RC_SHAPE
RC_SHAPE(phong, gloss, 1, 1, "A power of the cosine about the mirrored way.")
RC_SHAPE_TABLE(
    phong, "Simplified gloss about the mirrored way, instead of `gloss`.",
    "Phong's lobe, reciprocal and bounded (Lafortune & Willems, 1994); exponent of 49.5 or less for cameras.")
RC_SHAPE_PARAMETER(phong, 0, "exponent", "", "1", "100", "Power of the cosine: half height at acos(0.5^(1 / n)).")
RC_SHAPE_PARAMETER(phong, 1, "reflectance", "", "0", "1", "Share of light that it mirrors at normal incidence.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_PHONG_H)
#define RAYCUBE_KERNELS_MATERIALS_PHONG_H

#include "kernels/materials/gloss.h"

static inline rc_real rc_phong_mirrored(RcParameters p, rc_real cosine) {
  (void)cosine;
  return p.of[1];
}

/* Facets' cosine to the power 4 n mirrors about as wide a lobe (Lewis, "Making Shaders More Physically Plausible",
 * 1994); GGX of this alpha is narrower at its top, but has tails: of n = 20 weights vary by 0.99 of their mean, with
 * the curvature of that cosine, alpha^2 = 1 / (n + 1), by 1.22. */
static inline rc_real rc_phong_roughness(RcParameters p) {
  return fmin(sqrt(RC_REAL(1.0) / (RC_REAL(2.0) * p.of[0] + RC_REAL(1.0))), RC_REAL(1.0));
}

static inline RcParameters rc_phong_widened(RcParameters p, rc_real least) {
  p.of[0] = fmin(p.of[0], RC_REAL(0.5) / (least * least) - RC_REAL(0.5));
  return p;
}

static inline rc_real rc_phong_eval(rc_real scale, RcParameters p, RcAngles a) {
  const rc_real cosine = a.cos_in * a.cos_out - a.along;
  if (!(a.cos_in > RC_REAL(1e-4) && a.cos_out > RC_REAL(1e-4) && cosine > 0)) return 0;
  return scale * p.of[1] * (p.of[0] + RC_REAL(2.0)) * RC_REAL(0.5) * RC_INVERSE_PI *
         pow(fmin(cosine, RC_REAL(1.0)), p.of[0]);
}
static inline RcLocal rc_phong_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  return rc_facets_sample(rc_phong_roughness(p), in, u, v);
}
static inline rc_real rc_phong_pdf(RcParameters p, RcAngles a) { return rc_facets_pdf(rc_phong_roughness(p), a); }

#endif
