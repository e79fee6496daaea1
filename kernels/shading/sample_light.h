/* Light of the open sky that each sample's surface takes for granted (the sky's rays bring what differs), and where the
 * sample lies on the plan's height axis. */
#ifndef RAYCUBE_KERNELS_SHADING_SAMPLE_LIGHT_H
#define RAYCUBE_KERNELS_SHADING_SAMPLE_LIGHT_H

#include "kernels/atmosphere/nodes.h"
#include "kernels/geometry/scene_arrays.h"
#include "kernels/light/lobe_albedo.h"
#include "kernels/light/spread.h"
#include "kernels/shading/pixel.h"

#define RC_SOLAR_COMPONENTS (RC_COMPONENTS - RC_THERMAL_COMPONENTS)

/* What an open sky sends onto a surface, by the surface's normal. */
typedef struct OpenSky {
  global const float4* irradiance_map; /* solar components, at the nodes of an octahedral map */
  int map_size;
  global const float4* tilt_irradiance; /* thermal components, at nodes of the normal's vertical component */
  global const float* open_share;       /* [surface]: how much of it is taken for granted */
#if RC_LOBE_ALBEDO
  LobeAlbedos albedos;
#endif
} OpenSky;

/* Solar irradiance of the last normal asked for: neighbouring samples of one triangle share theirs. */
typedef struct LastNormal {
  float x, y, z;
  float4 irradiance;
} LastNormal;

static inline float4 rc_solar_irradiance(const OpenSky* sky, float nx, float ny, float nz, LastNormal* last) {
  if (nx != last->x || ny != last->y || nz != last->z) {
    int node[3];
    float share[3];
    rc_octahedral_nodes(nx, ny, nz, sky->map_size, node, share);
    last->irradiance =
        fma((float4)(share[0]), sky->irradiance_map[node[0]],
            fma((float4)(share[1]), sky->irradiance_map[node[1]], share[2] * sky->irradiance_map[node[2]]));
    last->x = nx;
    last->y = ny;
    last->z = nz;
  }
  return last->irradiance;
}

/* Of the thermal sky the share `known`. The surroundings, the last component, have what lies below the horizon and the
 * rest of the sky: pi less the share of what the open sky takes of the hemisphere, and of shapes, to whose viewer more
 * or less of an even light goes, pi times `more`. */
static inline float4 rc_thermal_irradiance(const OpenSky* sky, float nz, float known, float more) {
  int tilt;
  float beyond;
  rc_node_weights(nz, -1.0f, 2.0f / (RC_TILT_NODES - 1), RC_TILT_NODES, &tilt, &beyond);
  float4 e = fma((float4)(1.0f - beyond), sky->tilt_irradiance[tilt], beyond * sky->tilt_irradiance[tilt + 1]);
  const float hemisphere = 3.14159265f;
  float4 surroundings = fma((float4)(known - 1.0f), e - hemisphere, e);
#if RC_LOBE_ALBEDO
  surroundings += hemisphere * more;
#endif
  const int last = RC_THERMAL_COMPONENTS - 1;
  e *= known;
  if (last == 0) e.x = surroundings.x;
  if (last == 1) e.y = surroundings.y;
  if (last == 2) e.z = surroundings.z;
  return e;
}

/* Files up to four components of one sample from row `first` on; `used`: how many of them the plan has. */
static inline void rc_file_components(ShadedSamples* samples, int first, int used, int s, float4 irradiance) {
  if (used > 0) samples->value[first][s] = irradiance.x;
  if (used > 1) samples->value[first + 1][s] = irradiance.y;
  if (used > 2) samples->value[first + 2][s] = irradiance.z;
  if (used > 3) samples->value[first + 3][s] = irradiance.w;
}

/* Whether light goes to the viewer from what slot s stands for: a side of a surface. */
static inline bool rc_scatters(const TracedPixel* traced, int s) {
  const int sample = RC_SAMPLE_OF(s);
  if (traced->instance[sample] == RC_NONE) return false;
  if (RC_SIDE_OF(s) == 0u) return true;
  global const float* at = traced->point + s;
  return at[RC_PLANE(RC_NORMAL_X)] != 0.0f || at[RC_PLANE(RC_NORMAL_Y)] != 0.0f || at[RC_PLANE(RC_NORMAL_Z)] != 0.0f;
}

/* Whether a slot stands for what a gloss sends, its first part or a further lobe. */
static inline bool rc_mirrors(global const Lobe* lobes, global const float* at, uint side) {
#if RC_FURTHER
  if (side >= RC_FURTHER_SIDE) return rc_is_further(lobes, at, RC_GLOSS_SIDE);
#endif
  return side == RC_GLOSS_SIDE;
}

/* Surface, place on the height axis and light taken for granted of every sample; zero where nothing was hit. */
static inline void rc_light_of_samples(SceneArrays scene, const TracedPixel* traced, global const Lobe* lobes,
                                       const OpenSky* sky, float height_first, float height_step,
                                       ShadedSamples* samples) {
  LastNormal last = {2.0f, 2.0f, 2.0f, (float4)(0.0f)}; /* no unit vector */
  for (int s = 0; s < RC_PADDED_SAMPLES; ++s) {
    uint id = RC_NONE;
    int h = 0;
    float f = 0.0f;
    for (int m = 0; m < RC_LIT; ++m) samples->value[m][s] = 0.0f;
#if RC_LOBE_ALBEDO
    samples->albedo[s] = 0.0f;
#endif
    if (rc_scatters(traced, s)) {
      global const float* at = traced->point + s;
      const float nx = at[RC_PLANE(RC_NORMAL_X)], ny = at[RC_PLANE(RC_NORMAL_Y)], nz = at[RC_PLANE(RC_NORMAL_Z)];
      const uint surface = rc_surface_of(scene, traced->primitive[RC_SAMPLE_OF(s)]);
      const bool granted = !rc_mirrors(lobes, at, RC_SIDE_OF(s)); /* of gloss nothing is */
      const float known = RC_COMPONENTS > 0 ? (granted ? sky->open_share[surface] : 0.0f) : 0.0f;
      float albedo = 1.0f;
#if RC_LOBE_ALBEDO
      const uint lobe = as_uint(at[RC_PLANE(RC_LOBE_AT)]);
      if (lobe > 0u)
        albedo = rc_lobe_albedo(
            sky->albedos, lobe - 1u, (float4)(nx, ny, nz, 0.0f),
            (float4)(at[RC_PLANE(RC_VIEWER_X)], at[RC_PLANE(RC_VIEWER_Y)], at[RC_PLANE(RC_VIEWER_Z)], 0.0f));
      samples->albedo[s] = albedo;
#endif
      id = surface | RC_SIDE_OF(s) << RC_SIDE_SHIFT;
      rc_node_weights(at[RC_PLANE(RC_POINT_Z)], height_first, height_step, RC_HEIGHTS, &h, &f);
      if (RC_SOLAR_COMPONENTS > 0)
        rc_file_components(samples, RC_SUN, RC_SOLAR_COMPONENTS, s,
                           known * rc_solar_irradiance(sky, nx, ny, nz, &last));
      if (RC_THERMAL_COMPONENTS > 0)
        rc_file_components(samples, RC_SUN + RC_SOLAR_COMPONENTS, RC_THERMAL_COMPONENTS, s,
                           rc_thermal_irradiance(sky, nz, known, albedo - 1.0f));
    }
    samples->surface[s] = id;
    samples->height_index[s] = (uint)h;
    samples->height_fraction[s] = f;
  }
}

#endif
