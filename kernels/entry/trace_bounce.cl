/* Reads: hits, surface points of make_surface, the scene, its ground's skyline and curves at the skeleton wavelengths,
 * the sky's maps. Writes: by pixel and part of its samples, what light that was scattered at least twice, or came
 * through a plate, adds, at each skeleton wavelength: of sun, skies and what matter sends by itself, radiance per unit
 * of all together (plan::Bounces::together), times pi; then of lamps, by their sources. Next: resolve. */
#include "kernels/geometry/trace_args.h"
#include "kernels/light/path_start.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/skyline.h"
#include "kernels/shared/camera_arguments.h"

RC_BODY trace_bounce_body(uint index, RC_PARAMETERS(RC_TRACE_BOUNCE_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  RC_GATHER_SURFACES(scene);
  const Skyline skyline = RC_GATHER_SKYLINE();
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  PathTables tables = {&tile,
                       lobes,
                       scattering,
                       skeleton_curve,
                       source_share,
                       ground_around,
                       {sky_map, sky_zenith, sky_azimuth, zeniths, azimuths, thermal_map, thermal_zenith,
                        thermal_zeniths, sun_azimuth, tile.components, tile.thermal_components},
                       sun_direction,
                       lowest,
                       sun_up,
                       levels,
                       seed,
                       {lamps, lamp_first, lamp_distribution},
                       path_log + (size_t)place.pixel * log_paths * (levels + 1u),
                       log_paths RC_GATHER_ALBEDOS()};
  const uint samples = samples_u * samples_v;
  global float* out = glow + rc_glow_at(&tile, place.pixel, 0u);
  global const float* group_in = surface + rc_surface_at(&tile, place.pixel);
  const SkyDensity cosine = {1.0f, 0.0f, 0.5f, 0.0f, 0.0f, 1.0f};
  Paths16 waiting;
  waiting.count = waiting.live = 0;
  First16 first;
  rc_clear_first(&first);
  if (first_sample == 0u)
    for (uint i = 0; i < place.used * (uint)rc_glow_at(&tile, 1u, 0u); ++i) out[i] = 0.0f;
  for (uint i = 0; first_sample == 0u && i < place.used * tables.log_paths * (levels + 1u); ++i)
    tables.log[i].decided = 0u;
  for (uint p = 0; p < (levels ? place.used : 0u); ++p) {
    global const uint* ids = hits + rc_hits_at(&tile, place.pixel + p);
    global const float* in = surface + rc_surface_at(&tile, place.pixel + p);
    const uint number = place.number + p;
    for (uint part = 0; part < rc_sky_parts(samples, paths); ++part) {
      const SkyPart share = rc_sky_shares((int)sampler, samples_u, samples_v, paths, seed, number, part);
      for (uint path = 0; path < share.rays; ++path) {
        const uint sample = rc_sky_sample(share, samples_u, samples, paths, seed, number, part, path) - first_sample;
        if (sample >= sample_count) continue;
        global const uint* hit = ids + rc_hits_slot(sample);
        if (hit[0] == RC_NONE) continue;
        const uint on = rc_surface_of(scene, hit[RC_PLANE(RC_HIT_PRIMITIVE)]);
        const uint path_number = rc_sky_number(samples, paths, part, path), i = first.count;
        const float near = scattering[on].x, gloss = RC_GLOSSY ? scattering[on].z : 0.0f;
        const float draw = rc_path_draw(&tables, number, path_number, 0u, 0u);
        /* Roundings of a draw do not send a path through what is opaque. */
        const uint side = draw < gloss                                           ? RC_GLOSS_SIDE
                          : near >= 1.0f || draw - gloss < near * (1.0f - gloss) ? RC_NEAR_SIDE
                                                                                 : RC_FAR_SIDE;
        const bool straight = side == RC_FAR_SIDE && rc_is_plate(lobes, on);
        const uint slot = rc_slot_of_side(&tile, sample, straight ? RC_NEAR_SIDE : side);
        global const float* at = in + rc_surface_slot(slot);
        SkyRay ray =
            rc_slot_ray(cosine, tables.seed ^ 0x2545f491u, number, path_number, side == RC_GLOSS_SIDE, lobes, at);
        float4 point = (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
#if RC_PLATES
        if (tile.plates) {
          rc_put_first_plate(&tables, &first, i, straight, at, lift[rc_lift_at(&tile, place.pixel + p) + slot],
                             sun[rc_sun_at(&tile, place.pixel + p) + slot / RC_WORD] >> slot % RC_WORD & 1u, &ray,
                             &point);
          first.over_chance[i] = rc_over_chance(side, near, gloss);
        }
#endif
        if (!(RC_PLATES && tile.plates) && !(ray.facing > 0.0f)) continue;
        const float4 way = (float4)(ray.x, ray.y, ray.z, 0.0f);
        rc_put_ray(&first.rays, i, point, way);
        if (!(ray.z > 0.0f) || straight)
          first.down |= 1u << i;
        else if (rc_above_skyline(scene, &skyline, hit[0], point, way))
          first.clear |= 1u << i;
        first.weight[i] = side == RC_GLOSS_SIDE ? 0.318309886f * ray.facing / (ray.density * gloss)
                                                : rc_over_chance(side, near, gloss);
        first.scale[i] = share.scale * chunk_weight[sample] / sample_total;
        first.pixel[i] = p, first.part[i] = part, first.path[i] = path_number;
        first.slot[i] = slot, first.surface[i] = on, first.side[i] = side;
        first.sample[i] = first_sample + sample;
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
