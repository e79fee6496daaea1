/* Reads: hits, surface points of make_surface, the scene, its curves at the skeleton wavelengths, the sky's maps.
 * Writes: by pixel and part of its samples, what light of the sun and its sky that was scattered at least twice adds,
 * at each skeleton wavelength: radiance per unit of both together (plan::Bounces::together), times pi. Next: resolve.
 */
#include "kernels/geometry/trace_args.h"
#include "kernels/light/bounce.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/spread.h"
#include "kernels/shared/camera_arguments.h"

/* Lets a path begin on the side `side` of a sample's surface; at: its slot in the planes of surface. */
static inline void rc_begin_path(SceneArrays scene, const PathTables* t, global const float* at, uint surface,
                                 uint side, float chance, Paths16* paths) {
  const uint k = paths->count;
  const SkyDensity law = {1.0f, 0.0f, 0.5f, 0.0f, 0.0f, 1.0f}; /* the cosine alone */
  const SkyRay ray = rc_sky_ray(law, t->seed ^ 0x2545f491u, paths->number[k], paths->path[k], at[RC_PLANE(RC_NORMAL_X)],
                                at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)]);
  if (!(ray.facing > 0.0f)) return;
  float unit[RC_SKELETON], factor = 1.0f / chance;
  for (uint m = 0; m < RC_SKELETON; ++m) unit[m] = 1.0f;
#if RC_SHAPED
  if (side == 0u) factor *= rc_spread(at, (float4)(ray.x, ray.y, ray.z, 0.0f));
#endif
  rc_carry_on(scene, t, surface, side, factor, unit, paths->carried[k]);
  for (uint m = 0; m < RC_SKELETON; ++m) paths->gained[k][m] = 0.0f;
  paths->reach[k] = t->scattering[surface].y;
  rc_put_ray(&paths->rays, k,
             (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f),
             (float4)(ray.x, ray.y, ray.z, 0.0f));
  ++paths->count;
}

/* Follows what waits and adds it path by path, in their order: a sum does not depend on who waited together. */
static inline void rc_add_paths(SceneArrays scene, const PathTables* t, Paths16* paths, global float* out) {
  for (uint k = paths->count; k < 16u; ++k)
    rc_put_ray(&paths->rays, k, (float4)(0.0f), (float4)(0.0f, 0.0f, 1.0f, 0.0f));
  rc_follow(scene, t, paths);
  for (uint k = 0; k < paths->count; ++k) {
    global float* to = out + RC_GLOW_AT(paths->pixel[k], paths->part[k]);
    for (uint m = 0; m < RC_SKELETON; ++m) to[m] = fma(paths->scale[k], paths->gained[k][m], to[m]);
  }
  paths->count = 0;
}

RC_BODY trace_bounce_body(uint index, RC_PARAMETERS(RC_TRACE_BOUNCE_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  RC_GATHER_SURFACES(scene);
  const GroupPlace place = rc_group_place(groups, index, columns);
  PathTables tables = {
      lobes,
      scattering,
      skeleton_curve,
      source_share,
      ground_around,
      {sky_map, sky_zenith, sky_azimuth, zeniths, azimuths, thermal_map, thermal_zenith, thermal_zeniths, sun_azimuth},
      sun_direction,
      lowest,
      sun_up,
      levels,
      seed};
  const uint samples = RC_NU * RC_NV;
  global float* out = glow + RC_GLOW_AT(place.pixel, 0u);
  Paths16 waiting;
  waiting.count = 0;
  if (first_sample == 0u)
    for (uint i = 0; i < place.used * (uint)RC_GLOW_AT(1u, 0u); ++i) out[i] = 0.0f;
  for (uint p = 0; p < (levels ? place.used : 0u); ++p) {
    global const uint* ids = hits + RC_HITS_AT(place.pixel + p);
    global const float* in = surface + RC_SURFACE_AT(place.pixel + p);
    const uint number = place.number + p;
    for (uint part = 0; part < rc_sky_parts(samples, paths); ++part) {
      const SkyPart share = rc_sky_shares(RC_SAMPLER, RC_NU, RC_NV, paths, seed, number, part);
      for (uint path = 0; path < share.rays; ++path) {
        const uint sample = rc_sky_sample(share, RC_NU, samples, paths, seed, number, part, path) - first_sample;
        if (sample >= sample_count || ids[sample] == RC_NONE) continue;
        const uint on = rc_surface_of(scene, ids[RC_PLANE(RC_HIT_PRIMITIVE) + sample]), k = waiting.count;
        waiting.pixel[k] = p;
        waiting.part[k] = part;
        waiting.number[k] = number;
        waiting.path[k] = rc_sky_number(samples, paths, part, path);
        waiting.scale[k] = share.scale * chunk_weight[sample] / sample_total;
        const float near = scattering[on].x;
        const uint side = rc_path_draw(&tables, &waiting, k, 0u, 0u) < near ? 0u : 1u;
        rc_begin_path(scene, &tables, in + sample + side * RC_NEAR_SAMPLES, on, side, side ? 1.0f - near : near,
                      &waiting);
        if (waiting.count == 16u) rc_add_paths(scene, &tables, &waiting, out);
      }
    }
  }
  if (waiting.count) rc_add_paths(scene, &tables, &waiting, out);
}

kernel void trace_bounce(RC_PARAMETERS(RC_TRACE_BOUNCE_ARGUMENTS)) {
  trace_bounce_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_BOUNCE_ARGUMENTS));
}
