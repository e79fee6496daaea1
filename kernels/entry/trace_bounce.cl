/* Reads: hits, surface points of make_surface, the scene, its ground's skyline and curves at the skeleton wavelengths,
 * the sky's maps. Writes: by pixel and part of its samples, what light of the sun and its sky that was scattered at
 * least twice adds, at each skeleton wavelength: radiance per unit of both together (plan::Bounces::together), times
 * pi; then what light of lamps does, by their sources. Next: resolve. */
#include "kernels/geometry/trace_args.h"
#include "kernels/light/bounce.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/skyline.h"
#include "kernels/light/spread.h"
#include "kernels/shared/camera_arguments.h"

/* Follows what waits and adds it path by path, in their order: a sum does not depend on who waited together. */
static inline void rc_add_paths(SceneArrays scene, const PathTables* t, Paths16* paths, global float* out) {
  for (uint k = paths->count; k < 16u; ++k)
    rc_put_ray(&paths->rays, k, (float4)(0.0f), (float4)(0.0f, 0.0f, 1.0f, 0.0f));
  rc_follow(scene, t, paths);
  for (uint k = 0; k < paths->count; ++k) {
    global float* to = out + RC_GLOW_AT(paths->pixel[k], paths->part[k]);
    for (uint m = 0; m < RC_GLOW_WIDTH; ++m) to[m] = fma(paths->scale[k], paths->gained[k][m], to[m]);
  }
  paths->count = 0, paths->live = 0;
}

/* Paths whose first rays wait to be asked whether they meet anything: most see sky, whose light is scattered once. */
typedef struct First16 {
  Rays16 rays;
  float weight[16]; /* of the side and direction by which the path begins: by the cosine 1 over the side's chance */
  float scale[16];  /* as of Paths16 */
  uint pixel[16], part[16], path[16];
  uint slot[16], surface[16], side[16]; /* of the sample: in the planes of surface */
  uint count;
  uint down, clear; /* bits of rays that go below the horizon; that are known to miss the ground */
} First16;

/* Lets the paths that wait begin, in their order, if their first rays meet anything. in: surface points of the group's
 * first pixel; first_number: that pixel's. */
static inline void rc_begin_paths(SceneArrays scene, const PathTables* t, uint ground, First16* first,
                                  uint first_number, global const float* in, global float* out, Paths16* paths) {
  const uint asked = ((1u << first->count) - 1u) & ~first->down;
  Rays16 rays = first->rays;
  const uint hidden = first->down | (asked ? rc_hidden_of(scene, &rays, asked, ground, first->clear) : 0u);
  for (uint left = hidden; left; left &= left - 1u) {
    const uint i = rc_lowest(left);
    const uint k = paths->count;
    const float4 way = rc_way_of(&first->rays, i);
    rc_put_ray(&paths->rays, k, (float4)(first->rays.x[i], first->rays.y[i], first->rays.z[i], 0.0f), way);
    const bool meets = rc_meets(scene, paths, k);
    if (!meets && way.z > 0.0f) continue;
    float unit[RC_SKELETON], factor = first->weight[i], more[1 + RC_FURTHER];
    for (uint m = 0; m < RC_SKELETON; ++m) unit[m] = 1.0f;
    rc_further_factors(t->lobes, in + RC_SURFACE_AT(first->pixel[i]), first->slot[i], first->side[i], way, factor,
                       more);
#if RC_SHAPED
    if (first->side[i] != RC_FAR_SIDE)
      factor *= rc_spread(t->lobes, in + RC_SURFACE_AT(first->pixel[i]) + first->slot[i], way);
#endif
    rc_carry_on(scene, t, first->surface[i], first->side[i], factor, more, unit, paths->carried[k]);
    for (uint m = 0; m < RC_GLOW_WIDTH; ++m) paths->gained[k][m] = 0.0f;
    paths->reach[k] = first->side[i] == RC_GLOSS_SIDE ? 1.0f : t->scattering[first->surface[i]].y;
    paths->pixel[k] = first->pixel[i], paths->part[k] = first->part[i];
    paths->number[k] = first_number + first->pixel[i], paths->path[k] = first->path[i];
    paths->scale[k] = first->scale[i];
    if (meets)
      paths->live |= 1u << k;
    else
      rc_gain_ground(t, k, paths);
    if (++paths->count == 16u) rc_add_paths(scene, t, paths, out);
  }
  first->count = first->down = first->clear = 0;
}

RC_BODY trace_bounce_body(uint index, RC_PARAMETERS(RC_TRACE_BOUNCE_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  RC_GATHER_SURFACES(scene);
  const Skyline skyline = RC_GATHER_SKYLINE();
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
      seed RC_GATHER_LAMPS()};
  const uint samples = RC_NU * RC_NV;
  global float* out = glow + RC_GLOW_AT(place.pixel, 0u);
  global const float* group_in = surface + RC_SURFACE_AT(place.pixel);
  const SkyDensity cosine = {1.0f, 0.0f, 0.5f, 0.0f, 0.0f, 1.0f};
  Paths16 waiting;
  waiting.count = waiting.live = 0;
  First16 first;
  first.count = first.down = first.clear = 0;
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
        const uint on = rc_surface_of(scene, ids[RC_PLANE(RC_HIT_PRIMITIVE) + sample]);
        const uint path_number = rc_sky_number(samples, paths, part, path), i = first.count;
        const float near = scattering[on].x, gloss = RC_GLOSSY ? scattering[on].z : 0.0f;
        const float draw = rc_path_draw(&tables, number, path_number, 0u, 0u);
        /* Roundings of a draw do not send a path through what is opaque. */
        const uint side = draw < gloss                                           ? RC_GLOSS_SIDE
                          : near >= 1.0f || draw - gloss < near * (1.0f - gloss) ? RC_NEAR_SIDE
                                                                                 : RC_FAR_SIDE;
        const uint slot = RC_SLOT_OF(sample, side);
        global const float* at = in + slot;
        const SkyRay ray =
            rc_slot_ray(cosine, tables.seed ^ 0x2545f491u, number, path_number, side == RC_GLOSS_SIDE, lobes, at);
        if (!(ray.facing > 0.0f)) continue;
        const float4 point =
            (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
        const float4 way = (float4)(ray.x, ray.y, ray.z, 0.0f);
        rc_put_ray(&first.rays, i, point, way);
        if (!(ray.z > 0.0f))
          first.down |= 1u << i;
        else if (rc_above_skyline(scene, &skyline, ids[sample], point, way))
          first.clear |= 1u << i;
        first.weight[i] = side == RC_GLOSS_SIDE ? 0.318309886f * ray.facing / (ray.density * gloss)
                          : side == RC_FAR_SIDE ? 1.0f / ((1.0f - near) * (1.0f - gloss))
                                                : 1.0f / (near * (1.0f - gloss));
        first.scale[i] = share.scale * chunk_weight[sample] / sample_total;
        first.pixel[i] = p, first.part[i] = part, first.path[i] = path_number;
        first.slot[i] = slot, first.surface[i] = on, first.side[i] = side;
        if (++first.count == 16u)
          rc_begin_paths(scene, &tables, skyline.instance, &first, place.number, group_in, out, &waiting);
      }
    }
  }
  if (first.count) rc_begin_paths(scene, &tables, skyline.instance, &first, place.number, group_in, out, &waiting);
  if (waiting.count) rc_add_paths(scene, &tables, &waiting, out);
}

kernel void trace_bounce(RC_PARAMETERS(RC_TRACE_BOUNCE_ARGUMENTS)) {
  trace_bounce_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_BOUNCE_ARGUMENTS));
}
