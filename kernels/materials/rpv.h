/* Ground and canopies by the RPV model: Rahman, Pinty & Verstraete, "Coupled Surface-Atmosphere Reflectance (CSAR)
 * Model 2", J. Geophys. Res. 98 (D11), 1993, with a parameter for the hot spot (Engelsen et al., EUR 16426 EN, 1996):
 * pi f = rho_0 M(k) F(theta) H(rho_c), the same k, theta and rho_c at all wavelengths.
 * p[0]: k, 1: no bowl or bell; p[1]: theta, below 0 backwards; p[2]: rho_c, 1: no hot spot. */
#ifdef RC_SHAPE
RC_SHAPE(rpv, front, 1, 0, "The RPV model: bowl or bell, forward or backward lobe, hot spot.")
RC_SHAPE_TABLE(rpv, "Reflectance of ground or canopies by three numbers; the material's curve is rho_0.",
               "RPV (Rahman, Pinty & Verstraete, 1993), the same shape at all wavelengths.")
RC_SHAPE_PARAMETER(rpv, 0, "k", "", "0.4", "1.6", "Bowl (below 1, brighter towards the horizon) or bell (above 1).")
RC_SHAPE_PARAMETER(rpv, 1, "theta", "", "-0.6", "0.6",
                   "Asymmetry of the Henyey-Greenstein function; below 0: brighter towards the sun.")
RC_SHAPE_PARAMETER(rpv, 2, "rho_c", "", "0", "1", "Hot spot: 1 none, 0 twice as bright towards the sun.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_RPV_H)
#define RAYCUBE_KERNELS_MATERIALS_RPV_H

#include "kernels/materials/angles.h"

/* Beyond 80 degrees from the normal directions count as at 80, where a bowl would grow beyond bounds. */
static inline rc_real rc_rpv_eval(rc_real scale, RcParameters p, RcAngles a) {
  const rc_real k = p.of[0], theta = p.of[1], rho_c = p.of[2];
  if (!(a.cos_in > 0 && a.cos_out > 0)) return 0;
  const RcAngles b = rc_held(a, RC_REAL(0.17364817766693033));
  const rc_real bowl = pow(b.cos_in * b.cos_out * (b.cos_in + b.cos_out), k - RC_REAL(1.0));
  const rc_real phase = fma(b.cos_in, b.cos_out, b.along); /* of light that turns back: 1 */
  const rc_real spread = fma(theta, fma(RC_REAL(2.0), phase, theta), RC_REAL(1.0));
  const rc_real lobe = fma(-theta, theta, RC_REAL(1.0)) / (spread * sqrt(spread));
  const rc_real hot = RC_REAL(1.0) + (RC_REAL(1.0) - rho_c) / (RC_REAL(1.0) + sqrt(b.apart2));
  return scale * RC_INVERSE_PI * bowl * lobe * hot;
}
static inline RcLocal rc_rpv_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  (void)p, (void)in;
  return rc_cosine_law(u, v);
}
static inline rc_real rc_rpv_pdf(RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_out > 0 ? a.cos_out * RC_INVERSE_PI : 0;
}

#endif
