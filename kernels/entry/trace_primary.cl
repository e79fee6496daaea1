/* Reads: ray groups and the scene. Writes: instance and primitive of every sample's closest hit. Next: make_surface. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/bundle_primary.h"
#include "kernels/geometry/ray_trace.h"

#if RC_BUNDLE && !RC_MOVING && RC_SAMPLER == RC_SAMPLER_GRID
#define RC_PRIMARY_GRID 1
#endif

kernel void trace_primary(global const BvhNode* restrict nodes, global const TriBlock* restrict blocks,
                          global const Instance* restrict instances, global const RayGroup* restrict groups,
                          global uint* restrict hits, uint seed, uint first_line, uint first_column, uint columns,
                          uint pixels_per_line, uint first_sample, uint sample_count) {
  const uint index = get_group_id(0);
  const GroupPlace place = rc_group_place(index, first_line, first_column, columns, pixels_per_line);
  const RayGroup group = groups[index];
#ifdef RC_PRIMARY_GRID
  if (RC_SUPPORT == 1.0f) {
    Closest closest;
    for (uint k = 0; k < RC_GRID_SLOTS + 16; k += 16) {
      vstore16((float16)(0.0f), 0, closest.near + k);
      vstore16((uint16)(RC_NONE), 0, closest.instance + k);
      vstore16((uint16)(RC_NONE), 0, closest.primitive + k);
    }
    const uint rows = sample_count / RC_NU;
    rc_primary_group(nodes, blocks, instances, group, first_sample / RC_NU, rows, place.used * RC_NU, &closest);
    for (uint p = 0; p < place.used; ++p) {
      global uint* out = hits + (size_t)(place.pixel + p) * (2u * RC_NPAD);
      rc_write_pixel(closest.instance, p, rows, out);
      rc_write_pixel(closest.primitive, p, rows, out + RC_NPAD);
    }
    return;
  }
#endif
  for (uint p = 0; p < place.used; ++p) {
    global uint* out = hits + (size_t)(place.pixel + p) * (2u * RC_NPAD);
    for (uint k = 0; k < RC_NPAD; ++k) {
      Hit hit;
      hit.instance = hit.primitive = RC_NONE;
      if (k < sample_count) {
        float a, b;
        rc_group_sample(seed, place.number + p, p, first_sample + k, &a, &b);
        hit = rc_trace_ray(nodes, blocks, instances, rc_group_origin(group, b), rc_group_direction(group, a, b), false);
      }
      out[k] = hit.instance;
      out[RC_NPAD + k] = hit.primitive;
    }
  }
}
