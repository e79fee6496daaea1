/* Light of an open sky by direction: the plan's angular maps (host/plan/sky_basis.h), linear between the very nodes
 * that the open sky's irradiance is integrated over, so that both are one function. */
#ifndef RAYCUBE_KERNELS_LIGHT_SKY_MAP_H
#define RAYCUBE_KERNELS_LIGHT_SKY_MAP_H

#include "kernels/geometry/lanes.h"
#include "kernels/shared/tile_layout.h"

typedef struct SkyMap {
  global const float4* solar; /* [zenith][azimuth], components 0 .. 3, sr-1 */
  /* Nodes, ascending, then INFINITY up to whole words of 16; azimuths from the sun's, to either side. */
  global const float *zenith_rad, *azimuth_rad;
  uint zeniths, azimuths;       /* at least 2 of each */
  global const float4* thermal; /* [zenith], the thermal sky's components */
  global const float* thermal_zenith_rad;
  uint thermal_zeniths;
  float4 sun_azimuth;                  /* sin, cos of the azimuth from which the maps' counts, from north */
  uint components, thermal_components; /* of all, the solar ones first; of them, surroundings last */
} SkyMap;
#define RC_SKY_COMPONENTS 8 /* most of them */

/* Angle of (x, y) from the x axis, y >= 0, in 0 .. pi rad: to 2e-8 and the rounding of fp32 (Abramowitz & Stegun,
 * equation 4.4.49). The library's atan2 took an eighth of the sky's time. (0, 0) is at 0. */
static inline float rc_angle(float x, float y) {
  const float across = fabs(x), most = fmax(across, y);
  const float q = most > 0.0f ? fmin(across, y) / most : 0.0f, s = q * q;
  float sum = fma(s, 0.0028662257f, -0.0161657367f);
  sum = fma(s, sum, 0.0429096138f);
  sum = fma(s, sum, -0.0752896400f);
  sum = fma(s, sum, 0.1065626393f);
  sum = fma(s, sum, -0.1420889944f);
  sum = fma(s, sum, 0.1999355085f);
  sum = fma(s, sum, -0.3333314528f);
  const float acute = fma(q * s, sum, q), right = y > across ? 1.57079632679489662f - acute : acute;
  return x < 0.0f ? 3.14159265358979324f - right : right;
}

/* Cell of ascending nodes that holds `at`, and the fraction inside it; clamped to the axis. All nodes are compared at
 * once: a search waits for one after the other. */
static inline uint rc_map_cell(global const float* nodes, uint count, float at, float* fraction) {
  uint passed = 0;
  for (uint word = 0; word * 16u < count; ++word) passed += popcount(rc_mask16(rc_load16(word, nodes) <= at));
  const uint lo = clamp(passed, 1u, count - 1u) - 1u;
  *fraction = clamp((at - nodes[lo]) / (nodes[lo + 1u] - nodes[lo]), 0.0f, 1.0f);
  return lo;
}

/* Components that come from a unit direction above the horizon, sr-1, into light[RC_SKY_COMPONENTS]: the solar ones,
 * those of the thermal sky, then the surroundings', -1: what the sky loses, they gain. */
static inline void rc_sky_light(const SkyMap* map, float x, float y, float z, float* light) {
  const uint solar = map->components - map->thermal_components;
  for (uint m = 0; m < RC_SKY_COMPONENTS; ++m) light[m] = 0.0f;
  if (map->components == 0u) return;
  const float zenith = rc_angle(z, sqrt(fma(x, x, y * y)));
  if (solar > 0u) {
    float f, g;
    const float sine = map->sun_azimuth.x, cosine = map->sun_azimuth.y;
    const uint i = rc_map_cell(map->zenith_rad, map->zeniths, zenith, &f);
    const uint j = rc_map_cell(map->azimuth_rad, map->azimuths,
                               rc_angle(fma(x, sine, y * cosine), fabs(fma(x, cosine, -y * sine))), &g);
    global const float4 *low = map->solar + i * map->azimuths + j, *high = low + map->azimuths;
    const float4 value = fma((float4)(1.0f - f), fma((float4)(1.0f - g), low[0], g * low[1]),
                             f * fma((float4)(1.0f - g), high[0], g * high[1]));
    light[0] = value.x;
    if (solar > 1u) light[1] = value.y;
    if (solar > 2u) light[2] = value.z;
    if (solar > 3u) light[3] = value.w;
  }
  if (map->thermal_components > 0u) {
    float h;
    const uint k = rc_map_cell(map->thermal_zenith_rad, map->thermal_zeniths, zenith, &h);
    const float4 emitted = fma((float4)(1.0f - h), map->thermal[k], h * map->thermal[k + 1u]);
    if (map->thermal_components > 1u) light[solar] = emitted.x;
    if (map->thermal_components > 2u) light[solar + 1u] = emitted.y;
    light[map->components - 1u] = -1.0f;
  }
}

#endif
