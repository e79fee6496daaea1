/* GGX gloss beside the diffuse reflectance: Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
 * EGSR 2007; Schlick's Fresnel term. p[0]: roughness alpha of the distribution, p[1]: reflectance at normal
 * incidence. By Fresnel's law for an index (scene_compiler/fresnel.h) a gloss is a sum of lobes, p[2] says which: what
 * stands for Schlick's term is one of four functions of the angle, each with a curve of its own. */
#ifdef RC_SHAPE
RC_SHAPE(gloss, gloss, 1, 1, "GGX microfacets.")
RC_SHAPE_TABLE(gloss, "Gloss beside the diffuse reflectance; cameras ask for a roughness of 0.1 or more.",
               "GGX microfacets (Walter et al., 2007) with Schlick's Fresnel term.")
RC_SHAPE_PARAMETER(gloss, 0, "roughness", "", ">0", "1", "alpha of the GGX distribution.")
RC_SHAPE_PARAMETER(gloss, 1, "f0", "", "0", "1", "Reflectance of a facet at normal incidence.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_GLOSS_H)
#define RAYCUBE_KERNELS_MATERIALS_GLOSS_H

#include "kernels/materials/angles.h"

/* Smith's Lambda of GGX (Walter et al. 2007; Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based
 * BRDFs", JCGT 3(2), 2014, eq. 72). */
static inline rc_real rc_smith(rc_real alpha, rc_real cosine) {
  const rc_real square = fmax(RC_REAL(1.0) - cosine * cosine, RC_REAL(0.0)) / (cosine * cosine);
  return RC_REAL(0.5) * (sqrt(fma(alpha * alpha, square, RC_REAL(1.0))) - RC_REAL(1.0));
}

/* Density of facets' normals, 1/sr, times the cosine that projects them: integrates to 1. */
static inline rc_real rc_gloss_facets(rc_real alpha, RcAngles a) {
  const rc_real a2 = alpha * alpha, below = fma(a.cos_half * a.cos_half, a2, a.sin2_half);
  return a2 * RC_INVERSE_PI / (below * below);
}

/* What is mirrored, by the cosine between a way and the facet. */
static inline rc_real rc_gloss_mirrored(RcParameters p, rc_real cosine) {
  const rc_real f0 = p.of[1], bent = RC_REAL(1.0) - cosine, schlick = bent * bent * bent * bent * bent;
  if (p.of[2] == RC_REAL(0.0)) return fma(RC_REAL(1.0) - f0, schlick, f0);
  return p.of[2] == RC_REAL(1.0)   ? RC_REAL(1.0) - schlick
         : p.of[2] == RC_REAL(2.0) ? schlick
         : p.of[2] == RC_REAL(3.0) ? cosine * schlick * bent * bent * bent
                                   : cosine * bent * bent * bent;
}

/* Masking and shadowing are joined by the angle between the two ways' azimuths (van Ginneken et al. 1998; Heitz 2014,
 * eq. 96): 1 / (1 + max Lambda + m min Lambda), m = 4.41 phi / (4.41 phi + 1). At zero phase what the laser lights is
 * what the receiver sees: masking enters once. */
static inline rc_real rc_gloss_eval(rc_real scale, RcParameters p, RcAngles a) {
  const rc_real alpha = p.of[0];
  if (!(a.cos_in > RC_REAL(1e-4) && a.cos_out > RC_REAL(1e-4))) return 0;
  const rc_real phi = atan2(a.across, a.along), join = RC_REAL(4.41) * phi / fma(RC_REAL(4.41), phi, RC_REAL(1.0));
  const rc_real spread = rc_gloss_facets(alpha, a);
  const rc_real x = rc_smith(alpha, a.cos_in), y = rc_smith(alpha, a.cos_out);
  const rc_real masking = RC_REAL(1.0) / (RC_REAL(1.0) + fmax(x, y) + join * fmin(x, y));
  return scale * rc_gloss_mirrored(p, a.cos_turn) * spread * masking / (RC_REAL(4.0) * a.cos_in * a.cos_out);
}

/* Mirrored at a facet drawn from the distribution (Walter et al. 2007, eqs. 35, 36, 38); below the horizon, z < 0, for
 * facets that face away: such a path ends. */
static inline RcLocal rc_facets_sample(rc_real alpha, RcLocal in, rc_real u, rc_real v) {
  const rc_real tan2 = alpha * alpha * u / fmax(RC_REAL(1.0) - u, RC_REAL(1e-7)),
                cosine = RC_REAL(1.0) / sqrt(RC_REAL(1.0) + tan2);
  const rc_real sine = sqrt(tan2) * cosine, angle = RC_REAL(6.283185307179586) * v;
  const rc_real x = sine * cos(angle), y = sine * sin(angle);
  const rc_real twice = RC_REAL(2.0) * (in.x * x + in.y * y + in.z * cosine);
  RcLocal out;
  out.x = twice * x - in.x;
  out.y = twice * y - in.y;
  out.z = twice * cosine - in.z;
  return out;
}
static inline RcLocal rc_gloss_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  return rc_facets_sample(p.of[0], in, u, v);
}

/* Density of ways mirrored at such facets, 1/sr. */
static inline rc_real rc_facets_pdf(rc_real alpha, RcAngles a) {
  return a.cos_turn > 0 ? rc_gloss_facets(alpha, a) * a.cos_half / (RC_REAL(4.0) * a.cos_turn) : 0;
}
static inline rc_real rc_gloss_pdf(RcParameters p, RcAngles a) { return rc_facets_pdf(p.of[0], a); }

static inline rc_real rc_gloss_roughness(RcParameters p) { return p.of[0]; }
static inline RcParameters rc_gloss_widened(RcParameters p, rc_real least) {
  p.of[0] = fmax(p.of[0], least);
  return p;
}

/* Where a path goes on by a gloss: half of the ways mirrored at facets, half by the cosine law, so that no way is rarer
 * than light takes it; below the horizon, z < 0, it ends. Density of the ways above. */
static inline RcLocal rc_mirror_or_cosine(rc_real alpha, RcLocal in, rc_real u, rc_real v) {
  const rc_real half_way = RC_REAL(0.5);
  return u < half_way ? rc_facets_sample(alpha, in, RC_REAL(2.0) * u, v)
                      : rc_cosine_law(RC_REAL(2.0) * (u - half_way), v);
}
static inline rc_real rc_mirror_or_cosine_pdf(rc_real alpha, RcAngles a) {
  return RC_REAL(0.5) * (rc_facets_pdf(alpha, a) + a.cos_out * RC_INVERSE_PI);
}

#endif
