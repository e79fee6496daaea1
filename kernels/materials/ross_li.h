/* Ground and canopies as MODIS' products of albedo and BRDF have them: Ross-Thick and Li-Sparse-Reciprocal kernels,
 * Lucht, Schaaf & Strahler, "An Algorithm for the Retrieval of Albedo from Space Using Semiempirical BRDF Models", IEEE
 * TGRS 38(2), 2000, with h/b = 2 and b/r = 1: pi f = f_iso (1 + v K_vol + g K_geo), at least 0, v and g
 * the same at all wavelengths. p[0]: v = f_vol / f_iso; p[1]: g = f_geo / f_iso. */
#ifdef RC_SHAPE
RC_SHAPE(ross_li, front, 1, 0, "Ross-Thick and Li-Sparse-Reciprocal kernels.")
RC_SHAPE_TABLE(ross_li, "Reflectance of ground or canopies by kernels; the material's curve is f_iso.",
               "Ross-Li (Lucht, Schaaf & Strahler, 2000), h/b = 2, b/r = 1, the same weights at all wavelengths.")
RC_SHAPE_PARAMETER(ross_li, 0, "volumetric", "", "0", "2", "f_vol / f_iso: leaves in depth.")
RC_SHAPE_PARAMETER(ross_li, 1, "geometric", "", "0", "0.5", "f_geo / f_iso: crowns that shade.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_ROSS_LI_H)
#define RAYCUBE_KERNELS_MATERIALS_ROSS_LI_H

#include "kernels/materials/angles.h"

static inline rc_real rc_ross_thick(rc_real phase, rc_real cos_in, rc_real cos_out) {
  const rc_real turn = acos(phase), sine = sqrt(fmax(fma(-phase, phase, RC_REAL(1.0)), RC_REAL(0.0)));
  return fma(RC_REAL(1.5707963267948966) - turn, phase, sine) / (cos_in + cos_out) - RC_REAL(0.78539816339744831);
}

/* across: sin sin |sin azimuth|, as in RcAngles. */
static inline rc_real rc_li_sparse(rc_real phase, rc_real cos_in, rc_real cos_out, rc_real apart2, rc_real across) {
  const rc_real over = RC_REAL(1.0) / (cos_in * cos_out), secants = (cos_in + cos_out) * over;
  const rc_real t = across * over;
  const rc_real cosine = fmin(RC_REAL(2.0) * sqrt(fma(t, t, apart2)) / secants, RC_REAL(1.0));
  const rc_real sine = sqrt(fmax(fma(-cosine, cosine, RC_REAL(1.0)), RC_REAL(0.0)));
  const rc_real overlap = RC_INVERSE_PI * fma(-sine, cosine, acos(cosine)) * secants;
  return overlap - secants + RC_REAL(0.5) * (RC_REAL(1.0) + phase) * over;
}

/* Beyond 80 degrees from the normal directions count as at 80, where the kernels would grow beyond bounds. */
static inline rc_real rc_ross_li_eval(rc_real scale, RcParameters p, RcAngles a) {
  if (!(a.cos_in > 0 && a.cos_out > 0)) return 0;
  const RcAngles b = rc_held(a, RC_REAL(0.17364817766693033));
  const rc_real phase = fmin(fmax(fma(b.cos_in, b.cos_out, b.along), RC_REAL(-1.0)), RC_REAL(1.0));
  const rc_real volumetric = rc_ross_thick(phase, b.cos_in, b.cos_out),
                geometric = rc_li_sparse(phase, b.cos_in, b.cos_out, b.apart2, b.across);
  return scale * RC_INVERSE_PI * fmax(fma(p.of[0], volumetric, fma(p.of[1], geometric, RC_REAL(1.0))), RC_REAL(0.0));
}
static inline RcLocal rc_ross_li_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  (void)p, (void)in;
  return rc_cosine_law(u, v);
}
static inline rc_real rc_ross_li_pdf(RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_out > 0 ? a.cos_out * RC_INVERSE_PI : 0;
}

#endif
