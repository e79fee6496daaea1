/* Reads: surface points of make_surface, the scene, directions to the sun or into the sky. Writes, for the sun: one bit
 * per sample, seen or not; for the sky: per sample and component the irradiance that the blocked ones
 * of its directions take away. Launched once
 * for each, as one kernel: the walk through the scene is compiled once. Next: shading. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/shadow_points.h"
#include "kernels/geometry/ray_trace.h"

/* Points and normals of word `word` (16 samples) of pixels side by side. */
static inline global const float* rc_surface_word(global const float* surface, uint word) {
  return surface + RC_SURFACE_AT(word / RC_WORDS) + word % RC_WORDS * 16u;
}

static inline float16 rc_cosines(float4 direction, global const float* at) {
  return rc_project_row(direction, rc_load16(0, at + RC_PLANE(RC_NORMAL_X)), rc_load16(0, at + RC_PLANE(RC_NORMAL_Y)),
                        rc_load16(0, at + RC_PLANE(RC_NORMAL_Z)));
}

/* The samples of one part of a pixel side by side: where they came from, and their normals. */
typedef struct SkyPart {
  float nx[RC_PADDED_SAMPLES], ny[RC_PADDED_SAMPLES], nz[RC_PADDED_SAMPLES];
  ushort slot[RC_PADDED_SAMPLES];
  uint count;
} RC_LINE SkyPart;

/* Gathers the slots of part `part` of `share`; points left over in the last word lie on the first and face nothing. */
static inline void rc_gather_part(global const float* in, uint seed, uint number, uint first_sample, uint part,
                                  uint share, Points* points, SkyPart* held) {
  uint n = 0;
  for (uint slot = 0; slot < RC_PADDED_SAMPLES; ++slot) {
    if (rc_sky_part(seed, number, first_sample + slot, share) != part) continue;
    points->x[n] = in[RC_PLANE(RC_POINT_X) + slot];
    points->y[n] = in[RC_PLANE(RC_POINT_Y) + slot];
    points->z[n] = in[RC_PLANE(RC_POINT_Z) + slot];
    held->nx[n] = in[RC_PLANE(RC_NORMAL_X) + slot];
    held->ny[n] = in[RC_PLANE(RC_NORMAL_Y) + slot];
    held->nz[n] = in[RC_PLANE(RC_NORMAL_Z) + slot];
    held->slot[n++] = (ushort)slot;
  }
  held->count = n;
  points->words = (n + 15u) / 16u;
  for (; n < points->words * 16u; ++n) {
    points->x[n] = points->x[0];
    points->y[n] = points->y[0];
    points->z[n] = points->z[0];
    held->nx[n] = held->ny[n] = held->nz[n] = 0.0f;
  }
}

#define TRACE_LIGHT_PARAMETERS                                                                                       \
  RC_NODES, RC_BLOCKS, RC_INSTANCES, global const RayGroup *restrict groups, global const float *restrict surface,   \
      global const float4 *restrict directions, global const float4 *restrict weights,                               \
      global ushort *restrict sun_mask, global float *restrict blocked, uint sky, uint sets, uint count, uint share, \
      uint seed, uint columns, uint first_sample

RC_BODY trace_light_body(uint index, TRACE_LIGHT_PARAMETERS) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const GroupPlace place = rc_group_place(groups, index, columns);
  /* The next group's points come from memory while this one's rays are traced. */
  if (!sky)
    rc_prefetch(surface + RC_SURFACE_AT(place.pixel + place.used),
                RC_PIXELS_PER_GROUP * (uint)(RC_SURFACE_AT(1) * sizeof(float)));
  const uint sharing = sky ? 1u : place.used; /* pixels whose samples share a direction */
  for (uint p = 0; p < place.used; p += sharing) {
    const uint first = sky ? rc_hash(seed, place.number + p, 0u, 21u) % sets * count : 0u;
    global const float* in = surface + RC_SURFACE_AT(place.pixel + p);
    global ushort* seen = sun_mask + RC_SUN_AT(place.pixel + p);
    global float* out = blocked + RC_SKY_AT(place.pixel + p);
#if RC_BUNDLE
    Points points;
    SkyPart held;
    RC_LINE float sum[RC_PLANE(RC_SKY_PLANES)];
    points.costly = 0;
    for (uint part = 0; part < share; ++part) {
      if (sky) {
        rc_gather_part(in, seed, place.number + p, first_sample, part, share, &points, &held);
        for (uint row = 0; row < RC_SKY_PLANES; ++row)
          for (uint word = 0; word < points.words; ++word) rc_store16((float16)(0.0f), word, sum + RC_PLANE(row));
      } else {
        points.words = sharing * RC_WORDS;
        for (uint word = 0; word < points.words; ++word) {
          global const float* at = rc_surface_word(in, word);
          rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_X)), word, points.x);
          rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Y)), word, points.y);
          rc_store16(rc_load16(0, at + RC_PLANE(RC_POINT_Z)), word, points.z);
        }
      }
      for (uint j = 0; j < count / share; ++j) {
        const uint m = rc_sky_direction(part, j, share);
        const float4 direction = directions[first + m];
        for (uint word = 0; word < points.words; ++word) {
          const float16 facing = sky ? rc_project_row(direction, rc_load16(word, held.nx), rc_load16(word, held.ny),
                                                      rc_load16(word, held.nz))
                                     : rc_cosines(direction, rc_surface_word(in, word));
          points.live[word] = rc_mask16(facing > 0.0f);
        }
        rc_shadow_points(scene, direction, &points);
        if (!sky) break;
        for (uint word = 0; word < points.words; ++word) {
          const float16 facing =
              rc_project_row(direction, rc_load16(word, held.nx), rc_load16(word, held.ny), rc_load16(word, held.nz));
          const uint dark = rc_mask16(facing > 0.0f) & ~points.live[word];
          if (!dark) continue;
          const float16 cosine = select((float16)(0.0f), facing, rc_lanes(dark)) * (float)share;
          for (uint quad = 0; quad < RC_SKY_QUADS; ++quad) {
            const float4 weight = weights[(first + m) * RC_SKY_QUADS + quad];
            float* to = sum + RC_PLANE(4 * quad);
            rc_store16(fma((float16)(weight.x), cosine, rc_load16(word, to)), word, to);
            rc_store16(fma((float16)(weight.y), cosine, rc_load16(word, to + RC_PLANE(1))), word, to + RC_PLANE(1));
            rc_store16(fma((float16)(weight.z), cosine, rc_load16(word, to + RC_PLANE(2))), word, to + RC_PLANE(2));
            rc_store16(fma((float16)(weight.w), cosine, rc_load16(word, to + RC_PLANE(3))), word, to + RC_PLANE(3));
          }
        }
      }
      if (sky)
        for (uint row = 0; row < RC_SKY_PLANES; ++row)
          for (uint n = 0; n < held.count; ++n) out[RC_PLANE(row) + held.slot[n]] = sum[RC_PLANE(row) + n];
      else
        for (uint word = 0; word < points.words; ++word) seen[word] = (ushort)points.live[word];
    }
#else
    const uint words = sharing * RC_WORDS;
    for (uint word = 0; word < words; ++word) {
      uint lit = 0;
      for (uint bit = 0; bit < 16u; ++bit) {
        global const float* at = rc_surface_word(in, word) + bit;
        const float4 normal =
            (float4)(at[RC_PLANE(RC_NORMAL_X)], at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)], 0.0f);
        const float4 point =
            (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
        float4 sum[RC_SKY_QUADS];
        for (uint quad = 0; quad < RC_SKY_QUADS; ++quad) sum[quad] = (float4)(0.0f);
        const uint part = rc_sky_part(seed, place.number + p, first_sample + word * 16u + bit, share);
        for (uint j = 0; j < count / share; ++j) {
          const uint m = rc_sky_direction(part, j, share);
          const float4 direction = directions[first + m];
          const float cosine = fma(direction.x, normal.x, fma(direction.y, normal.y, direction.z * normal.z));
          if (!(cosine > 0.0f)) continue;
          const bool open = rc_trace_ray(scene, point, direction, true).instance == RC_NONE;
          if (sky && !open)
            for (uint quad = 0; quad < RC_SKY_QUADS; ++quad)
              sum[quad] = fma(weights[(first + m) * RC_SKY_QUADS + quad], (float4)(cosine * (float)share), sum[quad]);
          if (open) lit |= 1u << bit;
        }
        for (uint quad = 0; sky && quad < RC_SKY_QUADS; ++quad) {
          global float* to = out + RC_PLANE(4 * quad) + word * 16u + bit;
          to[0] = sum[quad].x;
          to[RC_PLANE(1)] = sum[quad].y;
          to[RC_PLANE(2)] = sum[quad].z;
          to[RC_PLANE(3)] = sum[quad].w;
        }
      }
      if (!sky) seen[word] = (ushort)lit;
    }
#endif
  }
}

kernel void trace_light(TRACE_LIGHT_PARAMETERS) {
  trace_light_body((uint)get_global_id(0), RC_PASS_NODES, RC_PASS_BLOCKS, RC_PASS_INSTANCES, groups, surface,
                   directions, weights, sun_mask, blocked, sky, sets, count, share, seed, columns, first_sample);
}
