/* Reads: hits, ray groups, the scene. Writes: of every sample the primitive that its ray meets first of those that let
 * no light through, leaves and plates on its way passed straight; RC_NONE where there is none.
 * For truth alone: the host counts what they are made of. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/ray_trace.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/path_ends.h"
#include "kernels/shared/camera_arguments.h"

#define RC_MOST_LEAVES 4096u /* on one ray: more would be an error of rounding */

/* Of `live`, the rays whose ends let light through; they are put behind them. */
__attribute__((noinline)) static uint rc_pass_leaves(SceneArrays scene, global const Lobe* lobes, uint live,
                                                     Rays16* rays, Ends16* ends) {
  uint on = 0;
  for (uint left = live; left; left &= left - 1u) {
    const uint k = rc_lowest(left), surface = rc_surface_of(scene, ends->primitive[k]);
    if (rc_is_leaf(lobes, surface) || rc_is_plate(lobes, surface)) on |= 1u << k;
  }
  if (on) rc_stand(scene, lobes, rays, on, ends);
  for (uint left = on; left; left &= left - 1u) {
    const uint k = rc_lowest(left);
    rc_put_ray(rays, k, rc_lane_of(ends->back, k), rc_way_of(rays, k));
  }
  return on;
}

/* Takes the live rays to what they meet next, and files it. Returns those that meet anything. */
__attribute__((noinline)) static uint rc_meet_next(SceneArrays scene, uint live, const Rays16* rays, Ends16* ends,
                                                   global uint* out) {
  uint on = 0;
  for (; live; live &= live - 1u) {
    const uint k = rc_lowest(live);
    const Hit hit = rc_trace_ray(scene, (float4)(rays->x[k], rays->y[k], rays->z[k], 0.0f), rc_way_of(rays, k));
    out[k] = hit.instance == RC_NONE ? RC_NONE : hit.primitive;
    ends->instance[k] = hit.instance, ends->primitive[k] = hit.primitive;
    if (hit.instance != RC_NONE) on |= 1u << k;
  }
  return on;
}

RC_BODY first_opaque_body(uint index, RC_PARAMETERS(RC_FIRST_OPAQUE_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  const RayGroup group = rc_group_rays(groups, index);
  const Sampling sampling = RC_GATHER_SAMPLING();
  for (uint p = 0; p < place.used; ++p)
    for (uint word = 0; word < rc_near_words(&tile); ++word) {
      global const uint* in = hits + rc_hits_at(&tile, place.pixel + p) + word * RC_HIT_WORD;
      global uint* out = opaque + rc_first_opaque_at(&tile, place.pixel + p) + word * RC_WORD;
      uint live = 0;
      Rays16 rays;
      Ends16 ends;
      for (uint k = 0; k < 16u; ++k) {
        float a, b;
        rc_group_sample(sampling, seed, place.number + p, p, first_sample + word * 16u + k, &a, &b);
        rc_put_ray(&rays, k, group.origin + rc_group_offset(group, a, b), normalize(rc_group_direction(group, a, b)));
        out[k] = in[k] == RC_NONE ? RC_NONE : in[RC_PLANE(RC_HIT_PRIMITIVE) + k];
        ends.instance[k] = in[k], ends.primitive[k] = out[k];
        if (in[k] != RC_NONE) live |= 1u << k;
      }
      live = live ? rc_pass_leaves(scene, lobes, live, &rays, &ends) : 0u;
      for (uint leaf = 0; live && leaf < RC_MOST_LEAVES; ++leaf) {
        live = rc_meet_next(scene, live, &rays, &ends, out);
        if (live) live = rc_pass_leaves(scene, lobes, live, &rays, &ends);
      }
    }
}

kernel void first_opaque(RC_PARAMETERS(RC_FIRST_OPAQUE_ARGUMENTS)) {
  first_opaque_body((uint)get_global_id(0), RC_PASSED(RC_FIRST_OPAQUE_ARGUMENTS));
}
