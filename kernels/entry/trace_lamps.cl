/* Reads: hits, surface points of make_surface, the scene, the lamps. Writes: by sample and source of lamps, their
 * irradiance on each side of its surface, by one ray each; with shapes times pi f. Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/any_hit.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/lamps.h"
#include "kernels/light/spread.h"
#include "kernels/shared/camera_arguments.h"

RC_BODY trace_lamps_body(uint index, RC_PARAMETERS(RC_TRACE_LAMPS_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  const LampTables tables = {lamps, lamp_first, lamp_distribution};
  for (uint p = 0; p < place.used; ++p) {
    global const uint* ids = hits + rc_hits_at(&tile, place.pixel + p);
    global const float* in = surface + rc_surface_at(&tile, place.pixel + p);
    global float* out = met_sky + rc_met_sky_at(&tile, place.pixel + p) + RC_PLANE(tile.components);
    for (uint word = 0; word < tile.words; ++word)
      for (uint source = 0; source < tile.lamps; ++source)
        rc_store16((float16)(0.0f), source, out + word * rc_met_word(&tile));
    for (uint slot = 0; slot < tile.own_sides * tile.near; ++slot) {
      const uint sample = rc_sample_of(&tile, slot), side = rc_side_of(&tile, slot);
      if (ids[rc_hits_slot(sample)] == RC_NONE) continue;
      global const float* at = in + rc_surface_slot(slot);
      const float4 normal =
          (float4)(at[RC_PLANE(RC_NORMAL_X)], at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)], 0.0f);
      if (!(dot(normal, normal) > 0.0f)) continue;
      const float4 from = (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
      const float4 point = from - lift[rc_lift_at(&tile, place.pixel + p) + slot] * normal; /* on the surface itself */
      const uint number = rc_lamp_number((int)sampler, samples_u, samples_v, first_sample + sample);
      for (uint source = 0; source < tile.lamps; ++source) {
        float u, v, w;
        rc_lamp_draws(seed, place.number + p, source, side, number, &u, &v, &w);
        const LampDraw lamp = rc_draw_lamp(&tables, source, point, normal, u, v, w);
        if (!(lamp.irradiance > 0.0f) || rc_lamp_hidden(scene, from, lamp)) continue;
        float light = lamp.irradiance;
#if RC_SHAPED
        light *= rc_spread(lobes, at, lamp.direction);
#endif
        out[RC_PLANE(source) + rc_met_slot(&tile, slot)] = light;
#if RC_FURTHER
        for (uint further = 0; further < tile.further; ++further) {
          const uint other = rc_slot_of_side(&tile, sample, RC_FURTHER_SIDE + further);
          global const float* there = in + rc_surface_slot(other);
          if (rc_is_further(lobes, there, side))
            out[RC_PLANE(source) + rc_met_slot(&tile, other)] =
                lamp.irradiance * rc_spread(lobes, there, lamp.direction);
        }
#endif
      }
    }
  }
}

kernel void trace_lamps(RC_PARAMETERS(RC_TRACE_LAMPS_ARGUMENTS)) {
  trace_lamps_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_LAMPS_ARGUMENTS));
}
