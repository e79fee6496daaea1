/* Reads: surface points of make_surface, the scene. Writes: one bit per sample, sun seen or not. Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/ray_trace.h"

kernel void trace_sun(global const BvhNode* restrict nodes, global const TriBlock* restrict blocks,
                      global const Instance* restrict instances, global const float* restrict surface,
                      global ushort* restrict sun_mask, float4 sun, uint columns, uint pixels) {
  const GroupPlace place = rc_group_place(get_group_id(0), 0u, 0u, columns, columns);
  for (uint p = 0; p < place.used && place.pixel + p < pixels; ++p) {
    global const float* in = surface + (size_t)(place.pixel + p) * (6u * RC_NPAD);
    for (uint word = 0; word < RC_NWORDS; ++word) {
      uint seen = 0;
      for (uint bit = 0; bit < 16; ++bit) {
        global const float* at = in + word * 16u + bit;
        const float4 normal = (float4)(at[3 * RC_NPAD], at[4 * RC_NPAD], at[5 * RC_NPAD], 0.0f);
        if (!(fma(normal.x, sun.x, fma(normal.y, sun.y, normal.z * sun.z)) > 0.0f)) continue;
        const float4 point = (float4)(at[0], at[RC_NPAD], at[2 * RC_NPAD], 0.0f);
        if (rc_trace_ray(nodes, blocks, instances, point, sun, true).instance == RC_NONE) seen |= 1u << bit;
      }
      sun_mask[(size_t)(place.pixel + p) * RC_NWORDS + word] = (ushort)seen;
    }
  }
}
