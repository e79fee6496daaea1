/* Reads: hits, surface points of make_surface, the scene, the sky's maps. Writes: by sample and component, what the
 * rays that the sample sends into the sky add to the share of the open sky that its surface takes for granted.
 * Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/any_hit.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/sky_map.h"
#include "kernels/light/spread.h"
#include "kernels/sampling/sky_rays.h"
#include "kernels/shared/camera_arguments.h"

/* The ray from one side of a sample's surface. at: its slot in the planes of surface; scale: samples that the ray
 * stands for; known: the share of the open sky that is taken for granted; met: the slot's sums by component. */
static inline void rc_meet_sky(SceneArrays scene, const SkyMap* map, SkyRay ray, global const float* at, float scale,
                               float known, global float* met) {
  if (!(ray.facing > 0.0f) || !(ray.z > 0.0f)) return;
  const float4 point = (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
  const float4 direction = (float4)(ray.x, ray.y, ray.z, 0.0f);
  float open = rc_any_hit(scene, point, direction) ? 0.0f : 1.0f;
#if RC_SHAPED
  if (open > 0.0f) open = rc_spread(at, direction);
#endif
  if (open == known) return;
  const float weight = scale * (open - known) * ray.facing / ray.density;
  float light[RC_SKY_PLANES];
  rc_sky_light(map, ray.x, ray.y, ray.z, light);
  for (uint m = 0; m < RC_COMPONENTS; ++m) met[RC_PLANE(m)] = fma(weight, light[m], met[RC_PLANE(m)]);
}

RC_BODY trace_sky_body(uint index, RC_PARAMETERS(RC_TRACE_SKY_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(groups, index, columns);
  const SkyMap map = {sky_map,     sky_zenith,     sky_azimuth,     zeniths,    azimuths,
                      thermal_map, thermal_zenith, thermal_zeniths, sun_azimuth};
  const SkyDensity law = {density.x, density.y, density.z, sun_direction.x, sun_direction.y, sun_direction.z};
  const uint samples = RC_NU * RC_NV;
  for (uint p = 0; p < place.used; ++p) {
    global const uint* ids = hits + RC_HITS_AT(place.pixel + p);
    global const float* in = surface + RC_SURFACE_AT(place.pixel + p);
    global float* out = met_sky + RC_MET_SKY_AT(place.pixel + p);
    const uint number = place.number + p;
    for (uint word = 0; word < RC_SKY_PLANES * RC_WORDS; ++word) rc_store16((float16)(0.0f), word, out);
    for (uint part = 0; part < rc_sky_parts(samples, rays); ++part) {
      const SkyPart share = rc_sky_shares(RC_SAMPLER, RC_NU, RC_NV, rays, seed, number, part);
      for (uint ray = 0; ray < share.rays; ++ray) {
        const uint sample = rc_sky_sample(share, RC_NU, samples, rays, seed, number, part, ray) - first_sample;
        if (sample >= sample_count || ids[sample] == RC_NONE) continue;
        const float known = open_share[rc_surface_of(scene, ids[RC_PLANE(RC_HIT_PRIMITIVE) + sample])];
        for (uint slot = sample; slot < RC_PADDED_SAMPLES; slot += RC_NEAR_SAMPLES) {
          global const float* at = in + slot;
          const SkyRay sent =
              rc_sky_ray(law, seed, number, rc_sky_number(samples, rays, part, ray), at[RC_PLANE(RC_NORMAL_X)],
                         at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)]);
          rc_meet_sky(scene, &map, sent, at, share.scale, known, out + slot);
        }
      }
    }
  }
}

kernel void trace_sky(RC_PARAMETERS(RC_TRACE_SKY_ARGUMENTS)) {
  trace_sky_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_SKY_ARGUMENTS));
}
