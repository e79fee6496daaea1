/* Light that surfaces on a path send by themselves. What hides the sky counts already as a black body at the
 * surroundings' temperature; so along paths goes what surfaces differ from it: what is met sends (1 - reflectance -
 * transmittance) (B(its temperature) - B(surroundings)), reflectance that of each lobe times its albedo towards the
 * path, the open sky its light less theirs (rc_sky_light), the world below the horizon nothing. Where all is of one
 * temperature, paths add no light and no noise. Asked for where a plan has thermal light. */
#ifndef RAYCUBE_KERNELS_LIGHT_HEAT_H
#define RAYCUBE_KERNELS_LIGHT_HEAT_H

#include "kernels/light/path_matter.h"

/* What a surface sends back of an even light towards `out` by its front and by its gloss, over its curves: 1 and 0 of
 * Lambert's law. further: the same by its further lobes. */
typedef struct EvenLight {
  float front, gloss, further[1 + RC_FURTHER];
} EvenLight;

static inline EvenLight rc_even_light(const PathTables* t, uint surface, float4 normal, float4 out) {
  EvenLight even;
  even.front = 1.0f, even.gloss = 0.0f;
  for (uint i = 0; i < RC_FURTHER; ++i) even.further[i] = 0.0f;
#if RC_SHAPED
  if (!t->tile->lobe_albedo) return even;
  const uint first = surface * RC_LOBE_STRIDE;
  even.front = rc_lobe_albedo(t->albedos, first, normal, out);
  for (uint i = 1; i < RC_LOBE_BEHIND; ++i)
    if (t->lobes[first + i].share > 0.0f) even.gloss = rc_lobe_albedo(t->albedos, first + i, normal, out);
  for (uint i = 0; RC_FURTHER && i < t->tile->further; ++i)
    even.further[i] = t->lobes[first + RC_LOBES + i].share > 0.0f
                          ? rc_lobe_albedo(t->albedos, first + RC_LOBES + i, normal, out)
                          : 0.0f;
#endif
  return even;
}

/* Of a material, 1 less all that it sends back and lets through, at 16 wavelengths from m on. */
static inline float16 rc_own_light(const PathTables* t, uint material, const EvenLight* even, uint m) {
  const float16 through = rc_curve_at(t, RC_CURVE_TRANSMITTANCE, material, m);
#if RC_SHAPED
  float16 back = fma(even->front, rc_curve_at(t, RC_CURVE_REFLECTANCE, material, m), through);
  if (even->gloss > 0.0f) back = fma(even->gloss, rc_curve_at(t, RC_CURVE_GLOSS, material, m), back);
  for (uint i = 0; RC_FURTHER && i < t->tile->further; ++i)
    if (even->further[i] > 0.0f) back = fma(even->further[i], rc_curve_at(t, RC_CURVE_FURTHER + i, material, m), back);
  return 1.0f - back;
#else
  return 1.0f - (rc_curve_at(t, RC_CURVE_REFLECTANCE, material, m) + through);
#endif
}

/* Adds that to what is gained. normal: of the side that is met; out: unit, back along the path. */
static inline void rc_gain_heat(SceneArrays scene, const PathTables* t, uint surface, float4 normal, float4 out,
                                const float* carried, float* gained) {
  global const Surface* s = rc_surface(scene, surface);
  const EvenLight even = rc_even_light(t, surface, normal, out);
  for (uint m = 0; m < t->tile->skeleton; m += RC_WORD) {
    float16 sent = 0.0f;
    for (uint i = 0; i < 4u; ++i) {
      if (s->material[i] == 0u || s->fraction[i] == 0.0f) continue;
      const float16 excess = rc_curve_at(t, RC_CURVE_HEAT, s->material[i] - 1u, m);
      const float16 own = rc_own_light(t, s->material[i] - 1u, &even, m);
      sent = fma(s->fraction[i] * own, excess, sent);
    }
    vstore16(fma(sent, vload16(0, carried + m), vload16(0, gained + m)), 0, gained + m);
  }
}

#endif
