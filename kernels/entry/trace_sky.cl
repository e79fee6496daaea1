/* Reads: surface points of make_surface, sky direction sets, the scene. Writes: per sample and component the irradiance
 * that blocked directions take away. Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/ray_trace.h"

kernel void trace_sky(global const BvhNode* restrict nodes, global const TriBlock* restrict blocks,
                      global const Instance* restrict instances, global const float* restrict surface,
                      global const float4* restrict directions, global const float4* restrict weights, global float* restrict blocked,
                      uint sets, uint count, uint seed, uint first_line, uint first_column, uint columns, uint pixels_per_line,
                      uint pixels) {
  const GroupPlace place = rc_group_place(get_group_id(0), first_line, first_column, columns, pixels_per_line);
  for (uint p = 0; p < place.used && place.pixel + p < pixels; ++p) {
    const uint set = rc_hash(seed, place.number + p, 0u, 21u) % sets;
    global const float* in = surface + (size_t)(place.pixel + p) * (6u * RC_NPAD);
    global float* out = blocked + (size_t)(place.pixel + p) * (4u * RC_NPAD);
    for (uint k = 0; k < RC_NPAD; ++k) {
      const float4 normal = (float4)(in[3 * RC_NPAD + k], in[4 * RC_NPAD + k], in[5 * RC_NPAD + k], 0.0f);
      const float4 point = (float4)(in[k], in[RC_NPAD + k], in[2 * RC_NPAD + k], 0.0f);
      float4 sum = (float4)(0.0f);
      for (uint m = 0; m < count; ++m) {
        const float4 direction = directions[set * count + m];
        const float cosine = fma(normal.x, direction.x, fma(normal.y, direction.y, normal.z * direction.z));
        if (!(cosine > 0.0f)) continue;
        if (rc_trace_ray(nodes, blocks, instances, point, direction, true).instance != RC_NONE)
          sum = fma(weights[set * count + m], (float4)(cosine), sum);
      }
      out[k] = sum.x;
      out[RC_NPAD + k] = sum.y;
      out[2 * RC_NPAD + k] = sum.z;
      out[3 * RC_NPAD + k] = sum.w;
    }
  }
}
