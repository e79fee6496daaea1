/* Reads: hits, surface points of make_surface, the scene, the sky's maps. Writes: by sample and component, what the
 * rays that the sample sends into the sky add to the share of the open sky that its surface takes for granted.
 * Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/any_hits16.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/skyline.h"
#include "kernels/light/sky_map.h"
#include "kernels/light/spread.h"
#include "kernels/sampling/sky_rays.h"
#include "kernels/shared/camera_arguments.h"

/* Rays of a group that wait to be traced together, and what they will be weighed by. */
typedef struct Waiting16 {
  Rays16 rays;
  float facing[16], density[16];
  float scale[16];          /* samples that the ray stands for */
  float known[16];          /* share of the open sky that is taken for granted */
  uint pixel[16], slot[16]; /* whose ray it is: pixel of the group, slot in its planes */
  uint clear;               /* bits of rays that are known to miss the ground */
  uint count;
} Waiting16;

/* Adds to a slot what a ray brings of the sky's components. */
static inline void rc_add_sky(uint components, const float* light, float weight, global float* to) {
  for (uint m = 0; m < components; ++m) to[RC_PLANE(m)] = fma(weight, light[m], to[RC_PLANE(m)]);
}

/* Adds what the waiting rays bring, in their order; none is left. ground: its instance; in, met: of the group's first
 * pixel. */
static inline void rc_meet_sky(SceneArrays scene, const TileShape* tile, global const Lobe* lobes, uint ground,
                               const SkyMap* map, Waiting16* waiting, global const float* in, global float* met) {
  const uint hidden = rc_first_hidden(scene, &waiting->rays, waiting->count, ground, waiting->clear);
  for (uint i = 0; i < waiting->count; ++i) {
    const float x = waiting->rays.dx[i], y = waiting->rays.dy[i], z = waiting->rays.dz[i], known = waiting->known[i];
    float open = hidden >> i & 1u ? 0.0f : 1.0f;
#if RC_SHAPED
    if (open > 0.0f)
      open = rc_spread(lobes, in + rc_surface_at(tile, waiting->pixel[i]) + rc_surface_slot(waiting->slot[i]),
                       (float4)(x, y, z, 0.0f));
#endif
    if ((RC_FURTHER == 0 || tile->further == 0u) && open == known) continue;
    const float weight = waiting->scale[i] * (open - known) * waiting->facing[i] / waiting->density[i];
    float light[RC_SKY_COMPONENTS];
    rc_sky_light(map, x, y, z, light);
    global float* to = met + rc_met_sky_at(tile, waiting->pixel[i]);
    rc_add_sky(tile->components, light, weight, to + rc_met_slot(tile, waiting->slot[i]));
#if RC_FURTHER
    const uint sample = rc_sample_of(tile, waiting->slot[i]), side = rc_side_of(tile, waiting->slot[i]);
    for (uint number = 0; number < tile->further; ++number) {
      const uint slot = rc_slot_of_side(tile, sample, RC_FURTHER_SIDE + number);
      global const float* at = in + rc_surface_at(tile, waiting->pixel[i]) + rc_surface_slot(slot);
      if (!rc_is_further(lobes, at, side)) continue;
      const float seen = hidden >> i & 1u ? 0.0f : rc_spread(lobes, at, (float4)(x, y, z, 0.0f));
      rc_add_sky(tile->components, light, waiting->scale[i] * (seen - known) * waiting->facing[i] / waiting->density[i],
                 to + rc_met_slot(tile, slot));
    }
#endif
  }
  waiting->count = waiting->clear = 0;
}

/* Lets the ray from one side of a sample's surface wait. at: its slot in the planes of surface; clear: whether it is
 * known to miss the ground. */
static inline void rc_let_wait(Waiting16* waiting, SkyRay ray, global const float* at, float scale, float known,
                               uint pixel, uint slot, bool clear) {
  const uint i = waiting->count++;
  waiting->clear |= clear ? 1u << i : 0u;
  rc_put_ray(&waiting->rays, i,
             (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f),
             (float4)(ray.x, ray.y, ray.z, 0.0f));
  waiting->facing[i] = ray.facing;
  waiting->density[i] = ray.density;
  waiting->scale[i] = scale;
  waiting->known[i] = known;
  waiting->pixel[i] = pixel;
  waiting->slot[i] = slot;
}

RC_BODY trace_sky_body(uint index, RC_PARAMETERS(RC_TRACE_SKY_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const Skyline skyline = RC_GATHER_SKYLINE();
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  const SkyMap map = {sky_map,
                      sky_zenith,
                      sky_azimuth,
                      zeniths,
                      azimuths,
                      thermal_map,
                      thermal_zenith,
                      thermal_zeniths,
                      sun_azimuth,
                      tile.components,
                      tile.thermal_components};
  const SkyDensity law = {density.x, density.y, density.z, sun_direction.x, sun_direction.y, sun_direction.z};
  const uint samples = samples_u * samples_v;
  global const float* group_in = surface + rc_surface_at(&tile, place.pixel);
  global float* group_out = met_sky + rc_met_sky_at(&tile, place.pixel);
  Waiting16 waiting;
  waiting.count = waiting.clear = 0;
  for (uint p = 0; p < place.used; ++p) {
    global const uint* ids = hits + rc_hits_at(&tile, place.pixel + p);
    global const float* in = surface + rc_surface_at(&tile, place.pixel + p);
    global float* out = met_sky + rc_met_sky_at(&tile, place.pixel + p);
    const uint number = place.number + p;
    for (uint word = 0; word < tile.sky_planes * tile.words; ++word) rc_store16((float16)(0.0f), word, out);
    for (uint part = 0; part < rc_sky_parts(samples, rays); ++part) {
      const SkyPart share = rc_sky_shares((int)sampler, samples_u, samples_v, rays, seed, number, part);
      for (uint ray = 0; ray < share.rays; ++ray) {
        const uint sample = rc_sky_sample(share, samples_u, samples, rays, seed, number, part, ray) - first_sample;
        if (sample >= sample_count) continue;
        global const uint* hit = ids + rc_hits_slot(sample);
        if (hit[0] == RC_NONE) continue;
        const float granted = open_share[rc_surface_of(scene, hit[RC_PLANE(RC_HIT_PRIMITIVE)])];
        for (uint number_of_side = 0; number_of_side < tile.own_sides; ++number_of_side) {
          const uint slot = sample + number_of_side * tile.near;
          global const float* at = in + rc_surface_slot(slot);
          const bool gloss = RC_GLOSSY && number_of_side > tile.through;
          const float known = gloss ? 0.0f : granted;
          const SkyRay sent = rc_slot_ray(law, seed, number, rc_sky_number(samples, rays, part, ray), gloss, lobes, at);
          if (!(sent.facing > 0.0f) || !(sent.z > 0.0f)) continue;
          const float4 point =
              (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
          const bool clear = rc_above_skyline(scene, &skyline, hit[0], point, (float4)(sent.x, sent.y, sent.z, 0.0f));
          rc_let_wait(&waiting, sent, at, share.scale, known, p, slot, clear);
          if (waiting.count == 16u)
            rc_meet_sky(scene, &tile, lobes, skyline.instance, &map, &waiting, group_in, group_out);
        }
      }
    }
  }
  if (waiting.count) rc_meet_sky(scene, &tile, lobes, skyline.instance, &map, &waiting, group_in, group_out);
}

kernel void trace_sky(RC_PARAMETERS(RC_TRACE_SKY_ARGUMENTS)) {
  trace_sky_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_SKY_ARGUMENTS));
}
