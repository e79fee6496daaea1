/* Reads: hits of trace_primary, ray groups, the scene. Writes: offset point and normal of every sample. Next: trace_sun,
 * trace_sky, shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/surface_point.h"

kernel void make_surface(global const TriBlock* restrict blocks, global const Instance* restrict instances,
                         global const RayGroup* restrict groups, global const uint* restrict hits, global float* restrict surface,
                         uint seed, uint first_line, uint first_column, uint columns, uint pixels_per_line, uint first_sample,
                         uint sample_count) {
  const uint index = get_group_id(0);
  const GroupPlace place = rc_group_place(index, first_line, first_column, columns, pixels_per_line);
  const RayGroup group = groups[index];
  for (uint p = 0; p < place.used; ++p) {
    global const uint* in = hits + (size_t)(place.pixel + p) * (2u * RC_NPAD);
    global float* out = surface + (size_t)(place.pixel + p) * (6u * RC_NPAD);
    for (uint k = 0; k < RC_NPAD; ++k) {
      SurfacePoint point;
      point.position = point.normal = (float4)(0.0f);
      if (k < sample_count && in[k] != RC_NONE) {
        float a, b;
        rc_group_sample(seed, place.number + p, p, first_sample + k, &a, &b);
        point = rc_surface_point(blocks, instances + in[k], in[RC_NPAD + k], rc_group_origin(group, b), rc_group_direction(group, a, b));
      }
      out[k] = point.position.x;
      out[RC_NPAD + k] = point.position.y;
      out[2 * RC_NPAD + k] = point.position.z;
      out[3 * RC_NPAD + k] = point.normal.x;
      out[4 * RC_NPAD + k] = point.normal.y;
      out[5 * RC_NPAD + k] = point.normal.z;
    }
  }
}
