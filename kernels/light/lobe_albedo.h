/* How much of an even light a surface's lobes send towards the viewer (scene_compiler/lobe_albedo.h): by that its
 * emission there differs from Lambert's. Asked for where a plan has thermal light and matter that is not Lambert's
 * (TileShape::lobe_albedo). */
#ifndef RAYCUBE_KERNELS_LIGHT_LOBE_ALBEDO_H
#define RAYCUBE_KERNELS_LIGHT_LOBE_ALBEDO_H

#include "kernels/light/sky_map.h"
#include "kernels/materials/angles.h"
#include "kernels/shared/tile_layout.h"

#if RC_SHAPED
typedef struct LobeAlbedos {
  global const uint* at;     /* [record of the lobes]: number of its table, from 1; 0: 1 everywhere, Lambert's */
  global const float* value; /* [table][RC_ALBEDO_AZIMUTHS][RC_ALBEDO_ZENITHS] */
} LobeAlbedos;

#define RC_GATHER_ALBEDOS() \
  , { albedo_at, albedo }
/* Of a record of the lobes, towards `viewer` off a surface of normal `normal`, both unit. */
static inline float rc_lobe_albedo(LobeAlbedos tables, uint record, float4 normal, float4 viewer) {
  const uint table = tables.at[record];
  if (table == 0u) return 1.0f;
  /* Along what is east and north on the surface, as RcAngles has them. */
  const float turned = viewer.z + rc_turned(viewer.x * normal.x + viewer.y * normal.y, normal.z,
                                            normal.x * normal.x + normal.y * normal.y);
  const float east = viewer.x - normal.x * turned, north = viewer.y - normal.y * turned;
  const float azimuth = rc_angle(east < 0.0f ? -north : north, fabs(east)) * ((RC_ALBEDO_AZIMUTHS - 1) * RC_INVERSE_PI);
  const float upright = clamp(dot(normal, viewer), 0.0f, 1.0f);
  const float zenith =
      rc_angle(upright, sqrt(fma(-upright, upright, 1.0f))) * ((RC_ALBEDO_ZENITHS - 1) * 2.0f * RC_INVERSE_PI);
  const uint a = min((uint)azimuth, RC_ALBEDO_AZIMUTHS - 2u), c = min((uint)zenith, RC_ALBEDO_ZENITHS - 2u);
  const float f = clamp(azimuth - (float)a, 0.0f, 1.0f), g = clamp(zenith - (float)c, 0.0f, 1.0f);
  global const float* low = tables.value + ((size_t)(table - 1u) * RC_ALBEDO_AZIMUTHS + a) * RC_ALBEDO_ZENITHS + c;
  global const float* high = low + RC_ALBEDO_ZENITHS;
  return fma(1.0f - f, fma(1.0f - g, low[0], g * low[1]), f * fma(1.0f - g, high[0], g * high[1]));
}
#else
#define RC_GATHER_ALBEDOS()
#endif

#endif
