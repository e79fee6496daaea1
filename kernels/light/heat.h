/* Light that surfaces on a path send by themselves. What hides the sky counts already as a black body at the
 * surroundings' temperature; so along paths goes what surfaces differ from it: what is met sends (1 - reflectance -
 * transmittance) (B(its temperature) - B(surroundings)), the open sky its light less theirs (rc_sky_light), the world
 * below the horizon nothing. Where all is of one temperature, paths add no light and no noise. Compiled in where a plan
 * has thermal light. */
#ifndef RAYCUBE_KERNELS_LIGHT_HEAT_H
#define RAYCUBE_KERNELS_LIGHT_HEAT_H

#include "kernels/light/path_matter.h"

#if RC_THERMAL_COMPONENTS
/* Adds that to what is gained. */
static inline void rc_gain_heat(SceneArrays scene, const PathTables* t, uint surface, const float* carried,
                                float* gained) {
  global const Surface* s = rc_surface(scene, surface);
  for (uint m = 0; m < RC_SKELETON; m += 16u) {
    float16 sent = 0.0f;
    for (uint i = 0; i < 4u; ++i) {
      if (s->material[i] == 0u || s->fraction[i] == 0.0f) continue;
      const float16 excess = rc_curve_at(t, RC_CURVE_HEAT, s->material[i] - 1u, m);
      const float16 own = 1.0f - (rc_curve_at(t, RC_CURVE_REFLECTANCE, s->material[i] - 1u, m) +
                                  rc_curve_at(t, RC_CURVE_TRANSMITTANCE, s->material[i] - 1u, m));
      sent = fma(s->fraction[i] * own, excess, sent);
    }
    vstore16(fma(sent, vload16(0, carried + m), vload16(0, gained + m)), 0, gained + m);
  }
}
#endif

#endif
