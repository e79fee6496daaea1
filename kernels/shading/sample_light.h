/* Light of the open sky that each sample's surface takes for granted (the sky's rays bring what differs), and where the
 * sample lies on the plan's height axis. */
#ifndef RAYCUBE_KERNELS_SHADING_SAMPLE_LIGHT_H
#define RAYCUBE_KERNELS_SHADING_SAMPLE_LIGHT_H

#include "kernels/atmosphere/nodes.h"
#include "kernels/geometry/scene_arrays.h"
#include "kernels/light/lobe_albedo.h"
#include "kernels/light/spread.h"
#include "kernels/shading/pixel.h"

/* What an open sky sends onto a surface, by the surface's normal. */
typedef struct OpenSky {
  global const float4* irradiance_map; /* solar components, at the nodes of an octahedral map */
  int map_size;
  global const float4* tilt_irradiance; /* thermal components, at nodes of the normal's vertical component */
  global const float* open_share;       /* [surface]: how much of it is taken for granted */
#if RC_SHAPED
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
static inline float4 rc_thermal_irradiance(const TileShape* tile, const OpenSky* sky, float nz, float known,
                                           float more) {
  int tilt;
  float beyond;
  rc_node_weights(nz, -1.0f, 2.0f / (RC_TILT_NODES - 1), RC_TILT_NODES, &tilt, &beyond);
  float4 e = fma((float4)(1.0f - beyond), sky->tilt_irradiance[tilt], beyond * sky->tilt_irradiance[tilt + 1]);
  const float hemisphere = 3.14159265f;
  float4 surroundings = fma((float4)(known - 1.0f), e - hemisphere, e);
  if (RC_SHAPED && tile->lobe_albedo) surroundings += hemisphere * more;
  const uint last = tile->thermal_components - 1u;
  e *= known;
  if (last == 0u) e.x = surroundings.x;
  if (last == 1u) e.y = surroundings.y;
  if (last == 2u) e.z = surroundings.z;
  return e;
}

/* Files up to four components of one sample from row `first` on; `used`: how many of them the plan has. */
static inline void rc_file_components(const TileShape* tile, ShadedSamples* samples, uint first, uint used, uint s,
                                      float4 irradiance) {
  float* to = samples->value + rc_value_slot(tile, first, s);
  if (used > 0u) to[0] = irradiance.x;
  if (used > 1u) to[RC_WORD] = irradiance.y;
  if (used > 2u) to[2 * RC_WORD] = irradiance.z;
  if (used > 3u) to[3 * RC_WORD] = irradiance.w;
}

/* Whether light goes to the viewer from what a slot stands for: a side of a surface. instance: that its ray met. */
static inline bool rc_scatters(uint instance, global const float* at, uint side) {
  if (instance == RC_NONE) return false;
  if (side == RC_NEAR_SIDE) return true;
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
static inline void rc_light_of_samples(SceneArrays scene, const TileShape* tile, const TracedPixel* traced,
                                       global const Lobe* lobes, const OpenSky* sky, float height_first,
                                       float height_step, ShadedSamples* samples) {
  const uint solar = tile->components - tile->thermal_components, lights = rc_lights(tile);
  LastNormal last = {2.0f, 2.0f, 2.0f, (float4)(0.0f)}; /* no unit vector */
  for (uint word = 0; word < lights * tile->words; ++word) rc_store16((float16)(0.0f), word, samples->value);
  for (uint s = 0; s < RC_WORD * tile->words; ++s) {
    const uint side = rc_side_of(tile, s);
    uint id = RC_NONE;
    int h = 0;
    float f = 0.0f;
#if RC_SHAPED
    samples->albedo[s] = 0.0f;
#endif
    global const uint* hit = traced->hits + rc_hits_slot(rc_sample_of(tile, s));
    global const float* at = traced->point + rc_surface_slot(s);
    if (rc_scatters(hit[0], at, side)) {
      const float nx = at[RC_PLANE(RC_NORMAL_X)], ny = at[RC_PLANE(RC_NORMAL_Y)], nz = at[RC_PLANE(RC_NORMAL_Z)];
      const uint surface = rc_surface_of(scene, hit[RC_PLANE(RC_HIT_PRIMITIVE)]);
      const bool granted = !rc_mirrors(lobes, at, side); /* of gloss nothing is */
      const float known = tile->components > 0u ? (granted ? sky->open_share[surface] : 0.0f) : 0.0f;
      float albedo = 1.0f;
#if RC_SHAPED
      const uint lobe = as_uint(at[RC_PLANE(RC_LOBE_AT)]);
      if (tile->lobe_albedo && lobe > 0u)
        albedo = rc_lobe_albedo(
            sky->albedos, lobe - 1u, (float4)(nx, ny, nz, 0.0f),
            (float4)(at[RC_PLANE(RC_VIEWER_X)], at[RC_PLANE(RC_VIEWER_Y)], at[RC_PLANE(RC_VIEWER_Z)], 0.0f));
      samples->albedo[s] = albedo;
#endif
      id = surface | side << RC_SIDE_SHIFT;
      rc_node_weights(at[RC_PLANE(RC_POINT_Z)], height_first, height_step, (int)tile->heights, &h, &f);
      if (solar > 0u)
        rc_file_components(tile, samples, tile->sun, solar, s, known * rc_solar_irradiance(sky, nx, ny, nz, &last));
      if (tile->thermal_components > 0u)
        rc_file_components(tile, samples, tile->sun + solar, tile->thermal_components, s,
                           rc_thermal_irradiance(tile, sky, nz, known, albedo - 1.0f));
    }
    samples->surface[s] = id;
    samples->height_index[s] = (uint)h;
    samples->height_fraction[s] = f;
  }
}

#endif
