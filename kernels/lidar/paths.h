/* Paths of 16 rays from their first surface to their end. */
#ifndef RAYCUBE_KERNELS_LIDAR_PATHS_H
#define RAYCUBE_KERNELS_LIDAR_PATHS_H

#include "kernels/lidar/scatter.h"

static inline float16 rc_pixel_of_way(const LidarTables* t, Vector16 way) {
  const float4 axis = t->shot[RC_SHOT_END_AXIS];
  return rc_pixel16(t, way, fma((float16)(axis.x), way.x, fma((float16)(axis.y), way.y, axis.z * way.z)));
}

/* Rays that a surface ends, at its place in time: half-way numbers split them over two bins, so that running sums of
 * the row are what is stopped on average during each bin. What a plate lets through meets it again on the way back.
 * Rows of pixels take their own rays. */
static inline void rc_stop(const LidarTables* t, Paths16* paths, const Vertex16* vertex, global float* stopped) {
  const float4 from_end = t->shot[RC_SHOT_FROM_END];
  const float16 position = fma(paths->path + rc_leg16(from_end, paths->place).more,
                               (float16)(t->settings[RC_SET_BINS_PER_M]), (float16)(t->shot[RC_SHOT_TIME].y));
  RC_LINE float lane[16];
  rc_store16(clamp(position, -1e9f, 1e9f), 0, lane);
  RC_LINE float pixels[16];
  rc_store16(rc_stops_by_pixel(t) ? rc_pixel_of_way(t, paths->way) : (float16)(0.0f), 0, pixels);
  const int base = as_int(t->shot[RC_SHOT_TIME].x);
  for (uint line = 0; line < RC_LINES(t); ++line) {
    RC_LINE float kept[16];
    rc_store16(paths->open[line], 0, kept);
    for (uint left = paths->live; left; left &= left - 1u) {
      const uint k = rc_lowest(left);
      const float plate = t->optics[vertex->surface[k] * RC_LINES(t) + line].z;
      const float ends = kept[k] * kept[k] * (1.0f - plate * plate);
      kept[k] *= plate;
      if (pixels[k] < 0.0f) continue;
      global float* row = stopped + ((uint)pixels[k] * RC_LINES(t) + line) * t->row;
      const float whole = floor(lane[k]), part = lane[k] - whole;
      const int bin = clamp(base + (int)whole, -t->padded_taps, t->bins + t->padded_taps), slot = bin + t->padded_taps;
      if (slot < (int)t->row) row[slot] += ends * (1.0f - part);
      if (slot + 1 < (int)t->row) row[slot + 1] += ends * part;
    }
    paths->open[line] = rc_load16(0, kept);
  }
}

/* 16 rays from Q, the place near the scene that points are kept relative to (layout.h). a, b: sub-rays or samples;
 * leaves: where each leaves from, beside the middle of the exit. */
static inline void rc_begin_rays(const LidarTables* t, float16 a, float16 b, uint first_ray, PulseRays16* rays,
                                 Vector16* leaves) {
  global const float4* shot = t->shot;
  const float4 du = shot[RC_SHOT_DU], dv = shot[RC_SHOT_DV];
  const Vector16 tilt = {fma(a, (float16)(du.x), b * dv.x), fma(a, (float16)(du.y), b * dv.y),
                         fma(a, (float16)(du.z), b * dv.z)};
  rays->origin = rc_vector16(shot[RC_SHOT_REFERENCE]);
  rays->direction = rc_plus16(rc_vector16(shot[RC_SHOT_AXIS]), tilt);
  rays->offset = rc_along16(rc_vector16(shot[RC_SHOT_RESIDUAL]), (float16)(shot[RC_SHOT_START].w), tilt);
  leaves->x = leaves->y = leaves->z = 0.0f;
  if (!RC_HAS(t, EXITS)) return;
  const float4 eu = shot[RC_SHOT_EXIT_U], ev = shot[RC_SHOT_EXIT_V];
  const float16 ea = rc_load16(0, t->exits + first_ray), eb = rc_load16(0, t->exits + rc_padded_rays(t) + first_ray);
  leaves->x = fma(ea, (float16)(eu.x), eb * ev.x);
  leaves->y = fma(ea, (float16)(eu.y), eb * ev.y);
  leaves->z = fma(ea, (float16)(eu.z), eb * ev.z);
  rays->offset = rc_plus16(rays->offset, *leaves);
}

/* Photons, way and energy that the rays of a word begin with. */
static inline void rc_begin_paths(const LidarTables* t, const PulseRays16* rays, int16 exists, uint first_ray,
                                  Paths16* paths) {
  global const float4* shot = t->shot;
  paths->way = rays->direction;
  if (RC_HAS(t, RECEIVER) || RC_HAS(t, GLOSS) || RC_HAS(t, SHAPED) || RC_MEDIA(t) || RC_CONTINUES(t)) {
    const float16 over_length = 1.0f / sqrt(rc_dot16(rays->direction, rays->direction));
    paths->way.x *= over_length;
    paths->way.y *= over_length;
    paths->way.z *= over_length;
  }
  float16 weight = shot[RC_SHOT_DU].w;
  if (RC_HAS(t, RECEIVER)) {
    /* A_r cos(psi) dOmega, dOmega = pitch^2 cos^3(psi): pixels on a plane of tangents. */
    const float4 start_axis = shot[RC_SHOT_START_AXIS];
    const float16 off = fma((float16)(start_axis.x), paths->way.x,
                            fma((float16)(start_axis.y), paths->way.y, start_axis.z * paths->way.z));
    weight *= (off * off) * (off * off);
  }
  paths->live = rc_mask16(exists);
  for (uint line = 0; line < RC_LINES(t); ++line) {
    paths->weight[line] = weight * t->photons[line];
    paths->passed[line] = 1.0f;
    paths->open[line] = 1.0f;
    if (!RC_LANE_ENERGY(t)) continue;
    const long16 lane = (long16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    paths->energy[line] =
        select((long16)(t->ledger_unit), (long16)(t->ledger_unit + 1), lane < t->ledger_rest - (long)first_ray);
  }
  paths->first_ray = first_ray;
  if (RC_HAS(t, BOUNCES))
    for (uint k = 0; k < 16u; ++k) paths->order[k] = 1;
  paths->path = 0.0f;
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) paths->depth[node] = 0.0f;
}

/* Rays that each pixel has, where they are kept for every pixel. */
static inline void rc_count_rays(const LidarTables* t, const Paths16* paths, global float* stopped) {
  if (!rc_stops_by_pixel(t)) return;
  RC_LINE float pixels[16];
  rc_store16(rc_pixel_of_way(t, paths->way), 0, pixels);
  global float* rays_of = stopped + (size_t)RC_OWN_PIXELS(t) * RC_LINES(t) * t->row;
  for (uint left = paths->live; left; left &= left - 1u) {
    const uint k = rc_lowest(left);
    if (pixels[k] >= 0.0f) rays_of[(uint)pixels[k]] += 1.0f;
  }
}

/* Energy at a vertex: what plates let through stays with the paths, the rest is absorbed or ends here; light that is
 * scattered on has taken its own (RC_FEATURE_BOUNCES). gone: what plates on the way let through. */
static inline void rc_split_at_vertex(const LidarTables* t, const Vertex16* vertex, Paths16* paths, float16* gone,
                                      LidarSums* sums) {
  for (uint line = 0; line < RC_LINES(t); ++line) {
    const float16 scattered = rc_scattered16(t, vertex, line);
    const float16 plate = RC_HAS(t, PLATES) ? rc_matter16(t, vertex, line, 2) : (float16)(0.0f);
    const long truncated = sums->ledger[line][RC_LEDGER_TRUNCATED];
    rc_split_energy(t, paths, line, plate, scattered, vertex->common != RC_NONE, sums, RC_LEDGER_TRUNCATED);
    if (RC_HAS(t, BOUNCES)) sums->ledger[line][RC_LEDGER_TRUNCATED] = truncated;
    if (!RC_HAS(t, PLATES)) continue;
    paths->weight[line] *= plate;
    gone[line] *= plate;
  }
}

/* Traces on the rays that plates let through and ends the others. last: none may go on. */
static inline void rc_pass_plates(SceneArrays scene, const LidarTables* t, const Vertex16* vertex,
                                  const PulseRays16* rays, bool last, Paths16* paths, uint16* instances,
                                  uint16* primitives, LidarSums* sums) {
  uint through = 0;
  RC_LINE float from[3][16], way[3][16];
  Hits16 hits;
  rc_store_vector16(vertex->back, from);
  rc_store_vector16(rays->direction, way);
  for (uint k = 0; k < 16u; ++k) {
    hits.instance[k] = RC_NONE;
    hits.primitive[k] = 0;
    if (!(paths->live >> k & 1u)) continue;
    float plate = 0.0f;
    for (uint line = 0; line < RC_LINES(t); ++line) plate += t->optics[vertex->surface[k] * RC_LINES(t) + line].z;
    if (!(plate > 0.0f) || last) continue;
    through |= 1u << k;
    ++sums->rays;
    const Hit hit = rc_trace_ray(scene, rc_lane4(from, k), rc_lane4(way, k));
    hits.instance[k] = hit.instance;
    if (hit.instance != RC_NONE) hits.primitive[k] = hit.primitive;
  }
  *instances = rc_load16(0, hits.instance);
  *primitives = rc_load16(0, hits.primitive);
  rc_end_lanes(t, paths, paths->live & ~through, sums, RC_LEDGER_TRUNCATED);
}

/* What an owner keeps from word to word. */
typedef struct OwnerMemory {
  Triangle triangle;               /* that its last rays met */
  Moments moments[RC_MOST_FOLDED]; /* of light scattered once */
} OwnerMemory;

static inline Moments* rc_moments(const LidarTables* t, OwnerMemory* memory) {
  return RC_HAS(t, FOLDED) ? memory->moments : 0;
}

static inline void rc_begin_memory(const LidarTables* t, OwnerMemory* memory) {
  memory->triangle.instance = RC_NONE;
  if (!RC_HAS(t, FOLDED)) return;
  for (uint line = 0; line < RC_LINES(t); ++line) rc_clear_moments(memory->moments + line);
}

/* What is kept, to the owner's rows. */
static inline void rc_fold_memory(const LidarTables* t, OwnerMemory* memory, RC_ROW_SPACE float* rows,
                                  LidarSums* sums) {
  if (!RC_HAS(t, FOLDED)) return;
  for (uint line = 0; line < RC_LINES(t); ++line)
    rc_fold_all(t, memory->moments + line, rows + (size_t)line * t->row, sums->sum[line]);
}

/* The rays of a word from their first hits on. a, b: sub-rays or samples (INFINITY: none). */
static inline void rc_follow_word(SceneArrays scene, const LidarTables* t, float16 a, float16 b, uint first_ray,
                                  uint16 instances, uint16 primitives, RC_ROW_SPACE float* first,
                                  RC_ROW_SPACE float* multiple, global float* stopped, OwnerMemory* memory,
                                  LidarSums* sums) {
  global const float4* shot = t->shot;
  const float4 reference = shot[RC_SHOT_REFERENCE], from_start = shot[RC_SHOT_FROM_START];
  const int16 exists = a < INFINITY;
  PulseRays16 rays;
  Vector16 leaves;
  Paths16 paths;
  rc_begin_rays(t, select((float16)(0.0f), a, exists), select((float16)(0.0f), b, exists), first_ray, &rays, &leaves);
  rc_begin_paths(t, &rays, exists, first_ray, &paths);
  if (RC_HAS(t, STOPPED) && RC_OWN_PIXELS(t) > 1u) rc_count_rays(t, &paths, stopped);
  float16 gone[RC_MOST_LINES]; /* what plates on the way let through: the way back meets them again */
  for (uint line = 0; line < RC_LINES(t); ++line) gone[line] = 1.0f;
  float16 weight[RC_MOST_LINES];
  float16 begins_z = (reference.z - from_start.z) + leaves.z,
          reached = 0.0f;                                   /* where the piece of the ray in question begins */
  for (uint crossings = 64u; crossings > 0u; --crossings) { /* ends by itself: the last lets nothing through */
    const uint missed = rc_mask16(instances == RC_NONE);
    rc_end_lanes(t, &paths, missed & paths.live, sums, RC_LEDGER_ESCAPED);
    if (!paths.live) return;
    Vertex16 vertex;
    rc_meet(scene, t, instances, primitives, paths.live, &rays, &memory->triangle, &vertex);
    const int16 live = rc_bits16(paths.live);
    const float16 along = select((float16)(0.0f), vertex.along, live);
    paths.place = rc_along16(rays.offset, along, rays.direction);
    const Vector16 travelled = rc_minus16(paths.place, leaves);
    const Leg16 leg = rc_leg16(from_start, travelled);
    const float16 range = leg.range;
    paths.first_range = range;
    rc_end_lanes(t, &paths, rc_mask16(range > t->settings[RC_SET_RANGE_LIMIT]) & paths.live, sums, RC_LEDGER_ESCAPED);
    if (!paths.live) return;
    paths.path = leg.more;
    rc_pass_segment(t, &paths, begins_z, paths.place, paths.way, range - reached, sums);
    begins_z = reference.z + paths.place.z;
    reached = range;
    const bool apart = shot[RC_SHOT_AXIS].w == 0.0f;
    for (uint line = 0; RC_HAS(t, PLATES) && line < RC_LINES(t); ++line) {
      weight[line] = paths.weight[line];
      paths.weight[line] *= apart ? (float16)(1.0f) : gone[line];
    }
    rc_connect(scene, t, &paths, &vertex, rc_leg_home(t, paths.place, leg), apart, first, rc_moments(t, memory), sums);
    for (uint line = 0; RC_HAS(t, PLATES) && line < RC_LINES(t); ++line) paths.weight[line] = weight[line];
    Paths16 scattered;
    if (RC_HAS(t, BOUNCES)) {
      scattered = paths;
      for (uint line = 0; line < RC_LINES(t); ++line)
        scattered.energy[line] = rc_share16(paths.energy[line], rc_scattered16(t, &vertex, line));
    }
    rc_split_at_vertex(t, &vertex, &paths, gone, sums);
    if (RC_HAS(t, STOPPED)) rc_stop(t, &paths, &vertex, stopped);
    if (RC_HAS(t, BOUNCES)) rc_scatter_on(scene, t, &scattered, &vertex, first_ray, multiple, sums);
    if (!RC_HAS(t, PLATES)) return;
    rc_pass_plates(scene, t, &vertex, &rays, crossings == 1u, &paths, &instances, &primitives, sums);
    if (!paths.live) return;
  }
}
#endif
