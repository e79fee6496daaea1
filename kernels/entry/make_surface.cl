/* Reads: hits of trace_primary, ray groups, the scene. Writes: offset point and normal of every sample, how far the
 * point was moved, and where some material is shaped the way to the viewer and the surface's shape. Next: trace_sun,
 * trace_sky, trace_lamps, trace_bounce, shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/lanes.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/scene_arrays.h"
#include "kernels/geometry/surface_side.h"
#include "kernels/light/far_side.h"
#include "kernels/light/shape_slots.h"
#include "kernels/shared/camera_arguments.h"

/* Corners of the samples' triangles, and the direction and origin of their rays. */
typedef struct Gathered {
  float corner[9][16], origin[3][16], direction[3][16];
} RC_LINE Gathered;

RC_BODY make_surface_body(uint index, RC_PARAMETERS(RC_MAKE_SURFACE_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  const RayGroup group = rc_group_rays(groups, index);
  const Sampling sampling = RC_GATHER_SAMPLING();
  for (uint p = 0; p < place.used; ++p)
    for (uint word = 0; word < rc_near_words(&tile); ++word) {
      global const uint* in = hits + rc_hits_at(&tile, place.pixel + p) + word * RC_HIT_WORD;
      global float* pixel_out = surface + rc_surface_at(&tile, place.pixel + p);
      global float* pixel_moved = lift + rc_lift_at(&tile, place.pixel + p);
      global float* out = pixel_out + word * RC_SURFACE_WORD;
      Gathered g;
      uint left = 0;
      RC_LINE float a[16], b[16];
      rc_group_samples(sampling, seed, place.number + p, p, first_sample + word * 16u, a, b);
      for (uint k = 0; k < 16u; ++k) {
        const uint primitive = in[k] == RC_NONE ? 0u : in[RC_PLANE(RC_HIT_PRIMITIVE) + k];
        global const float* at = (global const float*)rc_block(scene, primitive / RC_BLOCK) + primitive % RC_BLOCK;
        left |= in[k] == RC_NONE ? 0u : 1u << k;
#pragma unroll
        for (uint c = 0; c < 9u; ++c) g.corner[c][k] = at[16u * c];
        const float4 o = group.origin + rc_group_offset(group, a[k], b[k]), d = rc_group_direction(group, a[k], b[k]);
        g.origin[0][k] = o.x;
        g.origin[1][k] = o.y;
        g.origin[2][k] = o.z;
        g.direction[0][k] = d.x;
        g.direction[1][k] = d.y;
        g.direction[2][k] = d.z;
      }
      Vector16 v[3];
      SurfaceSide16 near;
      rc_clear_side(&near);
      for (uint c = 0; c < 3u; ++c) {
        v[c].x = rc_load16(0, g.corner[3u * c]);
        v[c].y = rc_load16(0, g.corner[3u * c + 1u]);
        v[c].z = rc_load16(0, g.corner[3u * c + 2u]);
      }
      const Vector16 origin = {rc_load16(0, g.origin[0]), rc_load16(0, g.origin[1]), rc_load16(0, g.origin[2])};
      const Vector16 direction = {rc_load16(0, g.direction[0]), rc_load16(0, g.direction[1]),
                                  rc_load16(0, g.direction[2])};
#if RC_THROUGH
      const uint through = tile.through ? rc_let_through(scene, lobes, in) : 0u;
      const Vector16 backwards = {-direction.x, -direction.y, -direction.z};
      SurfaceSide16 far;
      rc_clear_side(&far);
#endif
      while (left) { /* one instance after the other: its matrices are shared */
        const uint instance = in[rc_lowest(left)];
        const int16 lanes = rc_load16(0, in) == instance;
        left &= ~rc_mask16(lanes);
        rc_find_side(rc_instance(scene, instance), v, origin, direction, lanes, &near);
#if RC_THROUGH
        if (rc_mask16(lanes) & through)
          rc_find_side(rc_instance(scene, instance), v, origin, backwards, lanes & rc_bits16(through), &far);
#endif
      }
      rc_store_side(&near, out, pixel_moved + word * RC_WORD);
#if RC_SHAPED
      rc_store_shapes(scene, in, direction, out);
#endif
#if RC_THROUGH
      if (tile.through) {
        const uint slot = rc_slot_of_side(&tile, word * RC_WORD, RC_FAR_SIDE);
        rc_store_side(&far, pixel_out + rc_surface_slot(slot), pixel_moved + slot);
        rc_clear_shapes(pixel_out + rc_surface_slot(slot));
      }
#endif
#if RC_GLOSSY
      if (tile.own_sides > 1u + tile.through) {
        const uint slot = rc_slot_of_side(&tile, word * RC_WORD, RC_GLOSS_SIDE);
        rc_store_gloss(scene, lobes, in, direction, &near, pixel_out + rc_surface_slot(slot), pixel_moved + slot);
      }
#endif
#if RC_FURTHER
      for (uint number = 0; number < tile.further; ++number) {
        const uint slot = rc_slot_of_side(&tile, word * RC_WORD, RC_FURTHER_SIDE + number);
        rc_store_further(scene, lobes, in, direction, &near, number, pixel_out + rc_surface_slot(slot),
                         pixel_moved + slot);
      }
#endif
    }
}

kernel void make_surface(RC_PARAMETERS(RC_MAKE_SURFACE_ARGUMENTS)) {
  make_surface_body((uint)get_global_id(0), RC_PASSED(RC_MAKE_SURFACE_ARGUMENTS));
}
