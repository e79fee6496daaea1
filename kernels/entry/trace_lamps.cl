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
  const GroupPlace place = rc_group_place(groups, index, columns);
  const LampTables tables = {lamps, lamp_first, lamp_distribution};
  for (uint p = 0; p < place.used; ++p) {
    global const uint* ids = hits + RC_HITS_AT(place.pixel + p);
    global const float* in = surface + RC_SURFACE_AT(place.pixel + p);
    global float* out = met_sky + RC_MET_SKY_AT(place.pixel + p) + RC_PLANE(RC_COMPONENTS);
    for (uint word = 0; word < RC_LAMPS * RC_WORDS; ++word) rc_store16((float16)(0.0f), word, out);
    for (uint slot = 0; slot < RC_OWN_SIDES * RC_NEAR_SAMPLES; ++slot) {
      const uint sample = RC_SAMPLE_OF(slot);
      if (ids[sample] == RC_NONE) continue;
      global const float* at = in + slot;
      const float4 normal =
          (float4)(at[RC_PLANE(RC_NORMAL_X)], at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)], 0.0f);
      if (!(dot(normal, normal) > 0.0f)) continue;
      const float4 from = (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
      const float4 point = from - lift[RC_LIFT_AT(place.pixel + p) + slot] * normal; /* on the surface itself */
      const uint number = rc_lamp_number((int)sampler, samples_u, samples_v, first_sample + sample);
      for (uint source = 0; source < RC_LAMPS; ++source) {
        float u, v, w;
        rc_lamp_draws(seed, place.number + p, source, RC_SIDE_OF(slot), number, &u, &v, &w);
        const LampDraw lamp = rc_draw_lamp(&tables, source, point, normal, u, v, w);
        if (!(lamp.irradiance > 0.0f) || rc_lamp_hidden(scene, from, lamp)) continue;
        float light = lamp.irradiance;
#if RC_SHAPED
        light *= rc_spread(lobes, at, lamp.direction);
#endif
        out[RC_PLANE(source) + slot] = light;
#if RC_FURTHER
        for (uint number = 0; number < RC_FURTHER; ++number) {
          const uint other = RC_SLOT_OF(sample, RC_FURTHER_SIDE + number);
          if (rc_is_further(lobes, in + other, RC_SIDE_OF(slot)))
            out[RC_PLANE(source) + other] = lamp.irradiance * rc_spread(lobes, in + other, lamp.direction);
        }
#endif
      }
    }
  }
}

kernel void trace_lamps(RC_PARAMETERS(RC_TRACE_LAMPS_ARGUMENTS)) {
  trace_lamps_body((uint)get_global_id(0), RC_PASSED(RC_TRACE_LAMPS_ARGUMENTS));
}
