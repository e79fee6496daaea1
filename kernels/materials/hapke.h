/* Soils and regoliths by Hapke's model: single-scattering albedo w, the material's curve, in light that grains pass on
 * (Hapke, "Bidirectional reflectance spectroscopy 5", Icarus 157, 2002, equations 2 and 4 and H of equation 13;
 * shadow hiding as in part 4, Icarus 67, 1986; macroscopic roughness of part 3, Icarus 59, 1984). A double
 * Henyey-Greenstein phase function: a lobe of width b towards the light by (1 + c) / 2, one away from it.
 *   f = w / (4 pi (mu0e + mue)) [(1 + B) P + H(mu0e) H(mue) - 1] S mu0e / mu0
 * over r0 = (1 - gamma) / (1 + gamma), gamma = sqrt(1 - w), which its curve carries instead: so pi f is near 1 whatever
 * w. p[0]: b; p[1]: c; p[2]: mean slope angle, degrees; p[3]: B0, height of the shadow-hiding hot spot; p[4]: h, its
 * width; p[5]: w, of which the material's curve takes nodes (scene_compiler/spectral_shape.h). */
#ifdef RC_SHAPE
RC_SHAPE(hapke, front, 1, 0, "Hapke's model of soils: grains, shadow hiding, roughness.")
RC_SHAPE_TABLE(hapke, "Reflectance of soils and regoliths; the material's curve is the single-scattering albedo.",
               "Hapke (2002, 1986, 1984): H functions of 2002, shadow hiding, macroscopic roughness; the curve is w.")
RC_SHAPE_PARAMETER(hapke, 0, "b", "", "0", "0.7", "Width of the phase function's lobes.")
RC_SHAPE_PARAMETER(hapke, 1, "c", "", "-1", "1", "1: all of it towards the light, -1: away from it.")
RC_SHAPE_PARAMETER(hapke, 2, "slope_deg", "deg", "0", "60", "Mean slope angle of macroscopic roughness; 0: flat.")
RC_SHAPE_PARAMETER(hapke, 3, "b0", "", "0", "1", "Height of the hot spot by shadow hiding; 0: none.")
RC_SHAPE_PARAMETER(hapke, 4, "h", "", ">0", "1", "Its width: half of its height at a phase angle of 2 h rad.")
RC_SHAPE_CURVE(hapke, 5)
#elif !defined(RAYCUBE_KERNELS_MATERIALS_HAPKE_H)
#define RAYCUBE_KERNELS_MATERIALS_HAPKE_H

#include "kernels/materials/angles.h"

static inline rc_real rc_hapke_h(rc_real w, rc_real r0, rc_real x) {
  const rc_real slow = RC_REAL(0.5) * (RC_REAL(1.0) - RC_REAL(2.0) * r0 * x) * log((RC_REAL(1.0) + x) / x);
  return RC_REAL(1.0) / (RC_REAL(1.0) - w * x * (r0 + slow));
}

/* E1 and E2 of an angle by its cotangent; cot: of the mean slope angle. */
static inline rc_real rc_hapke_e1(rc_real cot, rc_real x) { return exp(RC_REAL(-2.0) * RC_INVERSE_PI * cot * x); }
static inline rc_real rc_hapke_e2(rc_real cot, rc_real x) { return exp(-RC_INVERSE_PI * cot * cot * x * x); }

/* Effective cosines towards and from rough ground, and S mu0e / mu0 by which it is darker than flat ground. */
typedef struct RcRough {
  rc_real in, out, darker;
} RcRough;

static inline RcRough rc_hapke_rough(rc_real slope_deg, RcAngles a) {
  RcRough flat, r;
  flat.in = a.cos_in, flat.out = a.cos_out, flat.darker = 1;
  if (!(slope_deg > 0)) return flat;
  const rc_real one = RC_REAL(1.0), least = RC_REAL(1e-6);
  const rc_real tangent = tan(slope_deg * RC_REAL(0.017453292519943296)), cot = one / tangent;
  const rc_real chi = one / sqrt(one + RC_REAL(3.14159265358979324) * tangent * tangent);
  const rc_real sin_in = sqrt(fmax(one - a.cos_in * a.cos_in, least * least)),
                sin_out = sqrt(fmax(one - a.cos_out * a.cos_out, least * least));
  const rc_real cot_in = a.cos_in / sin_in, cot_out = a.cos_out / sin_out;
  const rc_real psi = atan2(a.across, a.along), cos_psi = cos(psi), half2 = RC_REAL(0.5) * (one - cos_psi);
  const rc_real e1_in = rc_hapke_e1(cot, cot_in), e1_out = rc_hapke_e1(cot, cot_out);
  const rc_real e2_in = rc_hapke_e2(cot, cot_in), e2_out = rc_hapke_e2(cot, cot_out);
  const rc_real f = exp(RC_REAL(-2.0) * sqrt(half2 / fmax(one - half2, least * least)));
  const rc_real eta_in = chi * (a.cos_in + sin_in * tangent * e2_in / (RC_REAL(2.0) - e1_in)),
                eta_out = chi * (a.cos_out + sin_out * tangent * e2_out / (RC_REAL(2.0) - e1_out));
  const bool steep = a.cos_in > a.cos_out; /* light comes from nearer the normal than it goes to */
  const rc_real e1_far = steep ? e1_out : e1_in, e1_near = steep ? e1_in : e1_out;
  const rc_real e2_far = steep ? e2_out : e2_in, e2_near = steep ? e2_in : e2_out;
  const rc_real below = RC_REAL(2.0) - e1_far - psi * RC_INVERSE_PI * e1_near;
  const rc_real far = (e2_far - half2 * e2_near) / below, near = (cos_psi * e2_far + half2 * e2_near) / below;
  r.in = chi * (a.cos_in + sin_in * tangent * (steep ? near : far));
  r.out = chi * (a.cos_out + sin_out * tangent * (steep ? far : near));
  const rc_real fill = steep ? a.cos_in / eta_in : a.cos_out / eta_out;
  const rc_real s = r.out / eta_out * (a.cos_in / eta_in) * chi / (one - f + f * chi * fill);
  r.darker = s * r.in / a.cos_in;
  return r;
}

static inline rc_real rc_hapke_phase(rc_real b, rc_real c, rc_real cosine) {
  const rc_real square = b * b, back = RC_REAL(1.0) + square - RC_REAL(2.0) * b * cosine,
                on = RC_REAL(1.0) + square + RC_REAL(2.0) * b * cosine;
  return RC_REAL(0.5) * (RC_REAL(1.0) - square) *
         ((RC_REAL(1.0) + c) / (back * sqrt(back)) + (RC_REAL(1.0) - c) / (on * sqrt(on)));
}

/* Tangent of half the phase angle, whose cosine is given: where that is near 1 by the ways' distance, since a pulse
 * comes back within 1e-4 of where it came from. */
static inline rc_real rc_hapke_half_tan(RcAngles a, rc_real cosine) {
  const rc_real one = RC_REAL(1.0), apart = one / a.cos_in - one / a.cos_out;
  const rc_real near = RC_REAL(0.5) * a.cos_in * a.cos_out * (a.apart2 - apart * apart);
  const rc_real versine = cosine > RC_REAL(0.9) ? fmax(near, RC_REAL(0.0)) : one - cosine;
  return sqrt(versine / fmax(RC_REAL(2.0) - versine, RC_REAL(1e-12)));
}

static inline rc_real rc_hapke_eval(rc_real scale, RcParameters p, RcAngles a) {
  if (!(a.cos_in > RC_REAL(1e-4) && a.cos_out > RC_REAL(1e-4))) return 0;
  const rc_real one = RC_REAL(1.0), w = fmin(fmax(p.of[5], RC_REAL(1e-4)), one);
  const rc_real root = one + sqrt(one - w), over_r0 = root * root;                 /* w / r0 */
  const rc_real cosine = fmin(fmax(fma(a.cos_in, a.cos_out, a.along), -one), one); /* of the phase angle */
  const rc_real hidden = p.of[3] / (one + rc_hapke_half_tan(a, cosine) / p.of[4]);
  const RcRough r = rc_hapke_rough(p.of[2], a);
  const rc_real once = (one + hidden) * rc_hapke_phase(p.of[0], p.of[1], cosine),
                more = rc_hapke_h(w, w / over_r0, r.in) * rc_hapke_h(w, w / over_r0, r.out) - one;
  return scale * over_r0 * RC_REAL(0.25) * RC_INVERSE_PI / (r.in + r.out) * (once + more) * r.darker;
}
static inline RcLocal rc_hapke_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  (void)p, (void)in;
  return rc_cosine_law(u, v);
}
static inline rc_real rc_hapke_pdf(RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_out > 0 ? a.cos_out * RC_INVERSE_PI : 0;
}

#endif
