/* Paths of 16 rays from their first scattering on. */
#ifndef RAYCUBE_KERNELS_LIDAR_SCATTER_H
#define RAYCUBE_KERNELS_LIDAR_SCATTER_H

#include "kernels/lidar/energy.h"
#include "kernels/lidar/lobes.h"
#include "kernels/sampling/lidar_draws.h"

/* Direction in which a path goes on from a surface: on the side that it came from (`front`) by the surface's shape,
 * behind it by the cosine law. n: normal on that side; way: in which light arrived. spread: f cos over the direction's
 * density, per unit of reflectance, [lobe line]; 1 by Lambert's law. */
static inline float4 rc_draw_direction(const LidarTables* t, uint key, uint ray, uint step, uint surface, float4 n,
                                       float4 way, bool front, float* spread) {
  const float u = rc_unit_float(rc_hash(t->seed, key, ray, RC_DRAW_RADIUS(step))),
              v = rc_unit_float(rc_hash(t->seed, key, ray, RC_DRAW_ANGLE(step)));
  const Frame frame = rc_frame(front ? n : -n);
  if (RC_HAS(t, SHAPED) && front && rc_first_lobe(t, surface, 0u)->shape != RC_SHAPE_lambert) {
    const Lobe lobe = *rc_first_lobe(t, surface, 0u);
    const RcParameters p = rc_parameters(t->lobes, lobe);
    const float4 direction = rc_from_frame(frame, rc_shape_sample(lobe.shape, p, rc_to_frame(frame, -way), u, v));
    const RcAngles angles = rc_angles(n, -way, direction);
    for (uint line = 0; line < RC_LOBE_LINES(t); ++line)
      spread[line] = rc_front(t, surface, line, angles.cos_out, angles) / rc_shape_pdf(lobe.shape, p, angles);
    return direction;
  }
  return rc_from_frame(frame, rc_cosine_law(u, v));
}

/* The same by the surface's gloss, on the side that the path came from. */
static inline float4 rc_draw_mirrored(const LidarTables* t, uint key, uint ray, uint step, uint surface, float4 n,
                                      float4 way, float* spread) {
  const float u = rc_unit_float(rc_hash(t->seed, key, ray, RC_DRAW_RADIUS(step))),
              v = rc_unit_float(rc_hash(t->seed, key, ray, RC_DRAW_ANGLE(step)));
  const Frame frame = rc_frame(n);
  const float alpha = rc_gloss_alpha(t, surface);
  const float4 direction = rc_from_frame(frame, rc_mirror_or_cosine(alpha, rc_to_frame(frame, -way), u, v));
  const RcAngles angles = rc_angles(n, -way, direction);
  for (uint line = 0; line < RC_LOBE_LINES(t); ++line)
    spread[line] = angles.cos_out > 0.0f
                       ? rc_gloss(t, surface, line, angles) * angles.cos_out / rc_mirror_or_cosine_pdf(alpha, angles)
                       : 0.0f;
  return direction;
}

/* What a step does to energy and weight: what can go on goes on, in expectation over the lobes, the rest is booked. At
 * the first vertex light was split by the caller. */
static inline void rc_split_step(const LidarTables* t, const Vertex16* vertex, uint step, uint ended,
                                 float (*factor)[16], Paths16* paths, LidarSums* sums) {
  for (uint line = 0; line < RC_LINES(t); ++line) {
    RC_LINE float kept[16], booked[16];
    for (uint k = 0; k < 16u; ++k) {
      const float4 optics = t->optics[vertex->surface[k] * RC_LINES(t) + line];
      const float diffuse = step > 1u ? optics.x + optics.y + (RC_HAS(t, GLOSS) ? optics.w : 0.0f) : 1.0f,
                  plate = step > 1u ? optics.z : 0.0f;
      const bool last = paths->order[k] >= t->bounces;
      kept[k] = ended >> k & 1u ? 0.0f : last ? plate : diffuse + plate;
      booked[k] = ended >> k & 1u ? diffuse + plate : last ? diffuse : 0.0f;
    }
    rc_split_energy(t, paths, line, rc_load16(0, kept), rc_load16(0, booked), false, sums, RC_LEDGER_TRUNCATED);
    paths->weight[line] *= rc_load16(0, factor[line]);
  }
}

/* What a surface sends on by each way, summed over the lines: one choice is made for all, and each line's factor makes
 * up for it. last: what would scatter once more ends; on: plates let light go on. */
typedef struct Ways {
  float front, behind, straight, mirrored;
} Ways;
static inline Ways rc_ways(const LidarTables* t, uint surface, bool last, bool on) {
  Ways ways = {0.0f, 0.0f, 0.0f, 0.0f};
  for (uint line = 0; line < RC_LINES(t); ++line) {
    const float4 optics = t->optics[surface * RC_LINES(t) + line];
    ways.front += optics.x;
    ways.behind += optics.y;
    if (RC_HAS(t, GLOSS)) ways.mirrored += optics.w;
    ways.straight += on ? optics.z : 0.0f; /* at the first vertex the straight part is followed apart */
  }
  if (last) ways.front = ways.behind = ways.mirrored = 0.0f;
  return ways;
}

/* Follows the paths that scattered at their first vertex until they end; deposits at every further one. `first`: number
 * of the word's first ray. */
__attribute__((noinline, unused)) static void rc_scatter_on(SceneArrays scene, const LidarTables* t, Paths16* paths,
                                                            const Vertex16* at, uint first_ray,
                                                            RC_ROW_SPACE float* rows, LidarSums* sums) {
  const uint key = as_uint(t->shot[RC_SHOT_TIME].z);
  const float4 reference = t->shot[RC_SHOT_REFERENCE];
  Vertex16 vertex = *at;
  for (uint step = 1; paths->live; ++step) {
    RC_LINE float normal[3][16], front[3][16], back[3][16], way[3][16], from[3][16];
    RC_LINE float factor[RC_MOST_LINES][16];
    rc_store_vector16(vertex.normal, normal);
    rc_store_vector16(vertex.front, front);
    rc_store_vector16(vertex.back, back);
    rc_store_vector16(paths->way, way);
    rc_store_vector16(vertex.front, from);
    uint ended = 0, straight = 0;
    Hits16 hits;
    RC_LINE float reach[16];
    for (uint k = 0; k < 16u; ++k) {
      hits.instance[k] = RC_NONE;
      hits.primitive[k] = 0;
      reach[k] = 0.0f;
      for (uint line = 0; line < RC_LINES(t); ++line) factor[line][k] = 0.0f;
      if (!(paths->live >> k & 1u)) continue;
      const Ways ways = rc_ways(t, vertex.surface[k], paths->order[k] >= t->bounces, paths->order[k] && step > 1u);
      const float rho = ways.front, tau = ways.behind, plate = ways.straight, gloss = ways.mirrored;
      const float sum = rho + tau + plate + gloss;
      if (!(sum > 0.0f) || step >= t->bounces + 64u) {
        ended |= 1u << k;
        continue;
      }
      const float lobe = rc_unit_float(rc_hash(t->seed, key, first_ray + k, RC_DRAW_LOBE(step))) * sum;
      float4 direction = rc_lane4(way, k);
      float spread[RC_MOST_LINES];
      for (uint line = 0; line < RC_LOBE_LINES(t); ++line) spread[line] = 1.0f;
      const bool mirrored = RC_HAS(t, GLOSS) && gloss > 0.0f && lobe >= rho + tau + plate;
      if (mirrored) {
        direction =
            rc_draw_mirrored(t, key, first_ray + k, step, vertex.surface[k], rc_lane4(normal, k), direction, spread);
        if (!(dot(direction, rc_lane4(normal, k)) > 0.0f)) { /* into the surface */
          ended |= 1u << k;
          continue;
        }
      } else if (lobe >= rho + tau && plate > 0.0f) {
        straight |= 1u << k;
      } else {
        direction = rc_draw_direction(t, key, first_ray + k, step, vertex.surface[k], rc_lane4(normal, k), direction,
                                      lobe < rho, spread);
      }
      const bool behind = !mirrored && (straight >> k & 1u || lobe >= rho);
      const float chance = (mirrored ? gloss : straight >> k & 1u ? plate : behind ? tau : rho) / sum;
      for (uint line = 0; line < RC_LINES(t); ++line) {
        const float4 optics = t->optics[vertex.surface[k] * RC_LINES(t) + line];
        const float on = spread[rc_lobe_line(t, line)];
        const float sent = straight >> k & 1u ? optics.z : behind ? optics.y : optics.x * on;
        factor[line][k] = (mirrored ? on : sent) / chance;
      }
      const float4 origin = behind ? rc_lane4(back, k) : rc_lane4(front, k);
      way[0][k] = direction.x;
      way[1][k] = direction.y;
      way[2][k] = direction.z;
      from[0][k] = origin.x;
      from[1][k] = origin.y;
      from[2][k] = origin.z;
      ++sums->rays;
      const Hit hit = rc_trace_ray(scene, origin, direction);
      hits.instance[k] = hit.instance;
      if (hit.instance != RC_NONE) hits.primitive[k] = hit.primitive;
      reach[k] = hit.t;
    }
    rc_split_step(t, &vertex, step, ended, factor, paths, sums);
    paths->live &= ~ended;
    uint missed = 0;
    for (uint k = 0; k < 16u; ++k) {
      missed |= hits.instance[k] == RC_NONE ? 1u << k : 0u;
      if (!(straight >> k & 1u)) ++paths->order[k];
    }
    rc_end_lanes(t, paths, missed & paths->live, sums, RC_LEDGER_ESCAPED);
    if (!paths->live) return;
    const PulseRays16 rays = {rc_load_vector16(from), {0.0f, 0.0f, 0.0f}, rc_load_vector16(way)};
    rc_meet(scene, t, rc_load16(0, hits.instance), rc_load16(0, hits.primitive), paths->live, &rays, 0, &vertex);
    const int16 live = rc_bits16(paths->live);
    const float16 along = select((float16)(0.0f), fmax(vertex.along, 0.0f), live);
    const Vector16 start = rc_minus16(rays.origin, rc_vector16(reference)),
                   place = rc_along16(start, along, rays.direction);
    paths->place = rc_select_vector16(paths->place, place, live);
    paths->way = rc_select_vector16(paths->way, rays.direction, live);
    paths->path += along;
    rc_pass_segment(t, paths, rays.origin.z, paths->place, paths->way, along, sums);
    const float4 from_end =
        t->shot[RC_HAS(t, SHADOWS) ? RC_SHOT_FROM_END : RC_SHOT_FROM_START]; /* one place without shadows */
    rc_connect(scene, t, paths, &vertex, rc_leg16(from_end, paths->place), true, rows, 0, sums);
  }
}

#endif
