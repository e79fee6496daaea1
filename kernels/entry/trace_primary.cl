/* Reads: ray groups and the scene. Writes: instance and primitive of every sample's closest hit. Next: make_surface. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/ray_trace.h"

kernel void trace_primary(global const BvhNode* restrict nodes, global const TriBlock* restrict blocks,
                          global const Instance* restrict instances, global const RayGroup* restrict groups,
                          global uint* restrict hits, uint seed, uint first_line, uint first_column, uint columns,
                          uint pixels_per_line, uint first_sample, uint sample_count) {
  const uint index = get_group_id(0);
  const GroupPlace place = rc_group_place(index, first_line, first_column, columns, pixels_per_line);
  const RayGroup group = groups[index];
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
