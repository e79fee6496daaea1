/* Reads: surface points of make_surface, sky direction sets, the scene. Writes: per sample and component the irradiance
 * that blocked directions take away. Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/shadow_points.h"
#include "kernels/geometry/ray_trace.h"

kernel void trace_sky(RC_NODES, RC_BLOCKS, RC_INSTANCES, global const float* restrict surface,
                      global const float4* restrict directions, global const float4* restrict weights, global float* restrict blocked,
                      uint sets, uint count, uint seed, uint first_line, uint first_column, uint columns, uint pixels_per_line,
                      uint pixels) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(get_group_id(0), first_line, first_column, columns, pixels_per_line);
  for (uint p = 0; p < place.used && place.pixel + p < pixels; ++p) {
    const uint set = rc_hash(seed, place.number + p, 0u, 21u) % sets;
    global const float* in = surface + (size_t)(place.pixel + p) * (6u * RC_NPAD);
    global float* out = blocked + (size_t)(place.pixel + p) * (4u * RC_NPAD);
#if RC_BUNDLE
    Points points;
    float sum[4 * RC_NPAD];
    points.words = RC_NWORDS;
    points.costly = 0;
    for (uint word = 0; word < RC_NWORDS; ++word) {
      vstore16(vload16(word, in), word, points.x);
      vstore16(vload16(word, in + RC_NPAD), word, points.y);
      vstore16(vload16(word, in + 2 * RC_NPAD), word, points.z);
    }
    for (uint word = 0; word < 4 * RC_NWORDS; ++word) vstore16((float16)(0.0f), word, sum);
    for (uint m = 0; m < count; ++m) {
      const float4 direction = directions[set * count + m], weight = weights[set * count + m];
      float cosines[RC_NPAD];
      uint faces[RC_NWORDS];
      for (uint word = 0; word < RC_NWORDS; ++word) {
        const float16 cosine = rc_project_row(direction, vload16(word, in + 3 * RC_NPAD), vload16(word, in + 4 * RC_NPAD), vload16(word, in + 5 * RC_NPAD));
        vstore16(cosine, word, cosines);
        points.live[word] = faces[word] = rc_mask16(cosine > 0.0f);
      }
      rc_shadow_points(scene, direction, &points);
      for (uint word = 0; word < RC_NWORDS; ++word) {
        const uint dark = faces[word] & ~points.live[word];
        if (!dark) continue;
        const int16 lanes = rc_lanes(dark);
        const float16 cosine = select((float16)(0.0f), vload16(word, cosines), lanes);
        vstore16(fma((float16)(weight.x), cosine, vload16(word, sum)), word, sum);
        vstore16(fma((float16)(weight.y), cosine, vload16(word, sum + RC_NPAD)), word, sum + RC_NPAD);
        vstore16(fma((float16)(weight.z), cosine, vload16(word, sum + 2 * RC_NPAD)), word, sum + 2 * RC_NPAD);
        vstore16(fma((float16)(weight.w), cosine, vload16(word, sum + 3 * RC_NPAD)), word, sum + 3 * RC_NPAD);
      }
    }
    for (uint word = 0; word < 4 * RC_NWORDS; ++word) vstore16(vload16(word, sum), word, out);
#else
    for (uint k = 0; k < RC_NPAD; ++k) {
      const float4 normal = (float4)(in[3 * RC_NPAD + k], in[4 * RC_NPAD + k], in[5 * RC_NPAD + k], 0.0f);
      const float4 point = (float4)(in[k], in[RC_NPAD + k], in[2 * RC_NPAD + k], 0.0f);
      float4 sum = (float4)(0.0f);
      for (uint m = 0; m < count; ++m) {
        const float4 direction = directions[set * count + m];
        const float cosine = fma(direction.x, normal.x, fma(direction.y, normal.y, direction.z * normal.z));
        if (!(cosine > 0.0f)) continue;
        if (rc_trace_ray(scene, point, direction, true).instance != RC_NONE)
          sum = fma(weights[set * count + m], (float4)(cosine), sum);
      }
      out[k] = sum.x;
      out[RC_NPAD + k] = sum.y;
      out[2 * RC_NPAD + k] = sum.z;
      out[3 * RC_NPAD + k] = sum.w;
    }
#endif
  }
}
