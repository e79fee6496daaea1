/* Reads: surface points of make_surface, the scene. Writes: one bit per sample, sun seen or not. Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/shadow_points.h"
#include "kernels/geometry/ray_trace.h"

kernel void trace_sun(RC_NODES, RC_BLOCKS, RC_INSTANCES, global const float* restrict surface,
                      global ushort* restrict sun_mask, float4 sun, uint columns, uint pixels) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(get_group_id(0), 0u, 0u, columns, columns);
  const uint used = min(place.used, pixels - place.pixel);
#if RC_BUNDLE
  Points points;
  points.words = used * RC_NWORDS;
  points.costly = 0;
  for (uint word = 0; word < points.words; ++word) {
    global const float* at = surface + (size_t)(place.pixel + word / RC_NWORDS) * (6u * RC_NPAD) + word % RC_NWORDS * 16u;
    vstore16(vload16(0, at), word, points.x);
    vstore16(vload16(0, at + RC_NPAD), word, points.y);
    vstore16(vload16(0, at + 2 * RC_NPAD), word, points.z);
    points.live[word] = rc_mask16(rc_project_row(sun, vload16(0, at + 3 * RC_NPAD), vload16(0, at + 4 * RC_NPAD), vload16(0, at + 5 * RC_NPAD)) > 0.0f);
  }
  rc_shadow_points(scene, sun, &points);
  for (uint word = 0; word < points.words; ++word) sun_mask[(size_t)place.pixel * RC_NWORDS + word] = (ushort)points.live[word];
#else
  for (uint p = 0; p < used; ++p) {
    global const float* in = surface + (size_t)(place.pixel + p) * (6u * RC_NPAD);
    for (uint word = 0; word < RC_NWORDS; ++word) {
      uint seen = 0;
      for (uint bit = 0; bit < 16; ++bit) {
        global const float* at = in + word * 16u + bit;
        const float4 normal = (float4)(at[3 * RC_NPAD], at[4 * RC_NPAD], at[5 * RC_NPAD], 0.0f);
        if (!(fma(sun.x, normal.x, fma(sun.y, normal.y, sun.z * normal.z)) > 0.0f)) continue;
        const float4 point = (float4)(at[0], at[RC_NPAD], at[2 * RC_NPAD], 0.0f);
        if (rc_trace_ray(scene, point, sun, true).instance == RC_NONE) seen |= 1u << bit;
      }
      sun_mask[(size_t)(place.pixel + p) * RC_NWORDS + word] = (ushort)seen;
    }
  }
#endif
}
