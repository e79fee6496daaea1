/* What 16 scattering vertices send to the end (the pupil, or back to the exit), and where it goes in time. */
#ifndef RAYCUBE_KERNELS_LIDAR_CONNECT_H
#define RAYCUBE_KERNELS_LIDAR_CONNECT_H

#include "kernels/geometry/any_hits16.h"
#include "kernels/lidar/deposit.h"
#include "kernels/lidar/lobes.h"
#include "kernels/lidar/media.h"
#include "kernels/lidar/moments.h"
#include "kernels/lidar/overlap.h"
#include "kernels/lidar/vertex.h"

/* 16 paths at a scattering vertex. */
typedef struct Paths16 {
  Vector16 place;                    /* of the vertex, relative to Q */
  Vector16 way;                      /* unit, in which light arrived */
  float16 path;                      /* m, so far, minus |Q - start| */
  float16 weight[RC_MOST_LINES];     /* photons at the end per (1/sr of the vertex and what follows) */
  float16 depth[RC_MOST_LINE_NODES]; /* so far */
  float16 passed[RC_MOST_LINES];     /* transmission of `depth` */
  float16 open[RC_MOST_LINES];       /* share of the ray that plates let through so far (RC_FEATURE_STOPPED) */
  long16 energy[RC_MOST_LINES];      /* arriving, for the ledger (RC_LANE_ENERGY) */
  uint first_ray;                    /* of the word */
  float16 first_range;               /* m, from the start to the first vertex */
  uint order[16];                    /* scatterings, this one included */
  uint live;
} RC_LINE Paths16;

/* From an end of paths to points near Q. */
typedef struct Leg16 {
  Vector16 way;           /* m */
  float16 range, inverse; /* its length, and 1 over it */
  float16 more;           /* range minus |Q - end|, of small numbers alone */
} Leg16;

/* c: Q - end, with its length; e: points relative to Q. */
static inline Leg16 rc_leg16(float4 c, Vector16 e) {
  Leg16 leg;
  leg.way = rc_plus16(rc_vector16(c), e);
  const float16 square = rc_max16(rc_dot16(leg.way, leg.way), (float16)(1e-30f));
  leg.range = sqrt(square);
  leg.inverse = 1.0f / leg.range;
  const float16 dot = fma((float16)(c.x), e.x, fma((float16)(c.y), e.y, c.z * e.z));
  leg.more = fma((float16)(2.0f), dot, rc_dot16(e, e)) / (leg.range + c.w);
  return leg;
}

/* Pixels that places are seen in, v from the pupil and `deep` along its axis; -1: none. */
static inline float16 rc_pixel16(const LidarTables* t, Vector16 v, float16 deep) {
  const float4 u = t->shot[RC_SHOT_END_U], w = t->shot[RC_SHOT_END_V];
  const float columns = (float)t->columns, rows = (float)t->rows;
  const float16 step = 1.0f / (fmax(deep, 1e-30f) * t->settings[RC_SET_PITCH]);
  const float16 column =
      floor(fma(fma((float16)(u.x), v.x, fma((float16)(u.y), v.y, u.z * v.z)), step, (float16)(0.5f * columns)));
  const float16 row =
      floor(fma(fma((float16)(w.x), v.x, fma((float16)(w.y), v.y, w.z * v.z)), step, (float16)(0.5f * rows)));
  const int16 seen = (deep > 0.0f) & (column >= 0.0f) & (column < columns) & (row >= 0.0f) & (row < rows);
  return select((float16)(-1.0f), fma(row, (float16)(columns), column), seen);
}

/* Share of light that goes from a point to the end, plates on the way: visible[line]. towards: from the point to the
 * end. */
static inline uint rc_way_open(SceneArrays scene, const LidarTables* t, float4 from, float4 towards, float* share) {
  uint rays = 0;
  for (uint line = 0; line < RC_LINES(t); ++line) share[line] = 1.0f;
  if (!RC_HAS(t, PLATES)) {
    if (rc_way_blocked(scene, from, towards))
      for (uint line = 0; line < RC_LINES(t); ++line) share[line] = 0.0f;
    return 1u;
  }
  const float4 end = from + towards;
  for (uint crossing = 0; crossing < 64u; ++crossing) {
    const float4 rest = end - from;
    ++rays;
    const Hit hit = rc_trace_ray(scene, from, rest);
    if (!(hit.t < 1.0f)) return rays;
    const uint surface = rc_surface_of(scene, hit.primitive);
    bool any = false;
    for (uint line = 0; line < RC_LINES(t); ++line) {
      share[line] *= t->optics[surface * RC_LINES(t) + line].z;
      any |= share[line] > 0.0f;
    }
    if (!any) return rays;
    /* Past the plate by 32 ulp of the numbers that placed it. */
    const float4 at = fma((float4)(hit.t), rest, from), size = fabs(at) + fabs(from);
    from = at + rest * (32.0f * RC_ULP * (size.x + size.y + size.z) / length(rest.xyz));
  }
  for (uint line = 0; line < RC_LINES(t); ++line) share[line] = 0.0f;
  return rays;
}

/* Whether what lies past the end, seen from the scene, is none of it: ways that start in the scene's box and leave it
 * before their end may be asked without one. */
static inline bool rc_end_beyond(SceneArrays scene, const LidarTables* t) {
  global const BvhNode* root = rc_node(scene, 0u);
  const float4 end = t->shot[RC_SHOT_REFERENCE] - t->shot[RC_HAS(t, SHADOWS) ? RC_SHOT_FROM_END : RC_SHOT_FROM_START];
  float4 low = INFINITY, high = -INFINITY;
  for (uint slot = 0; slot < root->count; ++slot) {
    low = fmin(low, (float4)(root->lo_x[slot], root->lo_y[slot], root->lo_z[slot], 0.0f));
    high = fmax(high, (float4)(root->hi_x[slot], root->hi_y[slot], root->hi_z[slot], 0.0f));
  }
  const float slack = 64.0f * RC_ULP * root->reach;
  return end.x > high.x + slack || end.x < low.x - slack || end.y > high.y + slack || end.y < low.y - slack ||
         end.z > high.z + slack || end.z < low.z - slack;
}

/* Which of the lanes see the end, plates on the way: visible[line]. v: from the end to the vertices; facing: cosines
 * there. Returns how many rays were sent. */
static inline uint rc_ways_open(SceneArrays scene, const LidarTables* t, const Vertex16* vertex, Vector16 v,
                                float16 facing, uint lanes, float (*visible)[16]) {
  RC_LINE float place[3][16], front[3][16], back[3][16], side[16];
  uint rays = 0, asked = 0;
  rc_store_vector16(v, place);
  rc_store_vector16(vertex->front, front);
  rc_store_vector16(vertex->back, back);
  rc_store16(facing, 0, side);
  for (; lanes; lanes &= lanes - 1u) {
    const uint k = rc_lowest(lanes);
    bool any = side[k] > 0.0f;
    if (RC_HAS(t, LEAVES))
      for (uint line = 0; line < RC_LINES(t); ++line)
        any |= t->optics[vertex->surface[k] * RC_LINES(t) + line].y > 0.0f;
    if (any) asked |= 1u << k;
  }
  for (uint line = 0; line < RC_LINES(t); ++line)
    for (uint k = 0; k < 16u; ++k) visible[line][k] = 0.0f;
  if (!RC_HAS(t, PLATES) && popcount(asked) > RC_FEW_RAYS && rc_end_beyond(scene, t)) { /* sixteen at once */
    Rays16 ways;
    for (uint left = asked; left; left &= left - 1u) {
      const uint k = rc_lowest(left);
      rc_put_ray(&ways, k, side[k] > 0.0f ? rc_lane4(front, k) : rc_lane4(back, k), -rc_lane4(place, k));
    }
    const uint open = asked & ~rc_hidden_of(scene, &ways, asked, RC_NONE, 0u);
    for (uint line = 0; line < RC_LINES(t); ++line)
      for (uint left = open; left; left &= left - 1u) visible[line][rc_lowest(left)] = 1.0f;
    return popcount(asked);
  }
  for (; asked; asked &= asked - 1u) {
    const uint k = rc_lowest(asked);
    float share[RC_MOST_LINES];
    rays += rc_way_open(scene, t, side[k] > 0.0f ? rc_lane4(front, k) : rc_lane4(back, k), -rc_lane4(place, k), share);
    for (uint line = 0; line < RC_LINES(t); ++line) visible[line][k] = share[line];
  }
  return rays;
}

/* Depths of the whole ways, so far and home to the end; where no ray is sent, home is the way that the light came by.
 * */
static inline void rc_depths_home(const LidarTables* t, const Paths16* paths, Vector16 v, float16 range,
                                  float16 inverse, uint lanes, bool shadow, float16* depth) {
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) depth[node] = paths->depth[node] * (shadow ? 1.0f : 2.0f);
  if (!shadow) return;
  const float4 reference = t->shot[RC_SHOT_REFERENCE];
  if (RC_HAS(t, AIR)) {
    const float4 from_end = t->shot[RC_HAS(t, SHADOWS) ? RC_SHOT_FROM_END : RC_SHOT_FROM_START];
    rc_air_depths(t, (float16)(reference.z - from_end.z), reference.z + paths->place.z, range, depth);
  }
  if (RC_HAS(t, VOLUMES)) {
    const Vector16 outwards = {v.x * inverse, v.y * inverse, v.z * inverse};
    rc_volume_depths(t, rc_plus16(rc_vector16(reference), paths->place), outwards, range, lanes, depth);
  }
}

/* 1/sr: what is reflected per unit of reflectance, and the gloss beside it. */
typedef struct Lobes16 {
  float front[RC_MOST_LINES][16], gloss[RC_MOST_LINES][16];
} RC_LINE Lobes16;

/* Of light that arrived along `way` and leaves along `home`, in `lanes`. */
static inline void rc_lobes16(const LidarTables* t, const Vertex16* vertex, Vector16 way, Vector16 home, uint lanes,
                              Lobes16* lobes) {
  RC_LINE float normal[3][16], in[3][16], out[3][16];
  rc_store_vector16(vertex->normal, normal);
  rc_store_vector16(way, in);
  rc_store_vector16(home, out);
  for (uint k = 0; k < 16u; ++k) {
    for (uint line = 0; line < RC_LOBE_LINES(t); ++line) lobes->front[line][k] = lobes->gloss[line][k] = 0.0f;
    if (!(lanes >> k & 1u)) continue;
    const RcAngles angles = rc_angles(rc_lane4(normal, k), -rc_lane4(in, k), rc_lane4(out, k));
    for (uint line = 0; line < RC_LOBE_LINES(t); ++line) {
      if (RC_HAS(t, GLOSS)) lobes->gloss[line][k] = rc_gloss(t, vertex->surface[k], line, angles);
      if (RC_HAS(t, SHAPED)) lobes->front[line][k] = rc_front(t, vertex->surface[k], line, 1.0f, angles);
    }
  }
}

/* Factor of the geometry: all but weight, matter and air. v: from the end to the vertices, inverse: 1 over its length.
 * seen: lanes that the end can see at all; in_pixel: pixel of an array, where it has some. */
static inline float16 rc_end_geometry(const LidarTables* t, Vector16 v, float16 inverse, int16* seen,
                                      float16* in_pixel) {
  const float4 axis = t->shot[RC_SHOT_END_AXIS];
  const float16 deep = fma((float16)(axis.x), v.x, fma((float16)(axis.y), v.y, axis.z * v.z)),
                off_axis = deep * inverse;
  *seen &= deep > 0.0f;
  *in_pixel = 0.0f;
  const Vector16 beside = rc_along16(v, -deep, rc_vector16(axis));
  const float16 aside = rc_dot16(beside, beside);
  if (RC_HAS(t, RECEIVER)) {
    const bool gaussian = RC_HAS(t, GAUSSIAN);
    const float16 radius = fma(deep, (float16)(t->shot[RC_SHOT_END_U].w), (float16)(gaussian ? 0.0f : axis.w));
    float16 fluence;
    if (gaussian) {
      const float16 spot = fmax(fma(radius, radius, (float16)(axis.w * axis.w)), 1e-30f);
      fluence = 0.636619772f / spot * exp(-2.0f * aside / spot);
    } else {
      const float16 spot = fmax(radius * radius, 1e-30f);
      fluence = select((float16)(0.0f), 0.318309886f / spot, aside <= spot);
    }
    return fluence / fmax(off_axis, 1e-6f);
  }
  float16 geometry = off_axis * inverse * inverse;
  if (RC_HAS(t, PIXELS)) {
    *in_pixel = rc_pixel16(t, v, deep);
    *seen &= *in_pixel >= 0.0f;
  } else if (RC_HAS(t, OVERLAP)) {
    geometry *= rc_vignetting(t->settings, fmax(deep, 1e-20f), sqrt(aside));
  }
  return geometry;
}

/* From the end to places relative to Q: where both ends are one place, and rays leave from it, the way out was it. */
static inline Leg16 rc_leg_home(const LidarTables* t, Vector16 place, Leg16 out) {
  if (RC_HAS(t, EXITS)) return rc_leg16(t->shot[RC_HAS(t, SHADOWS) ? RC_SHOT_FROM_END : RC_SHOT_FROM_START], place);
  if (RC_HAS(t, SHADOWS) && t->shot[RC_SHOT_AXIS].w != 1.0f) return rc_leg16(t->shot[RC_SHOT_FROM_END], place);
  return out;
}

/* Deposits what lanes send into their pixels' rows of a line. */
static inline void rc_deposit_in_pixels(const LidarTables* t, RC_ROW_SPACE float* rows, uint line,
                                        float sums[RC_SUM_COUNT][2], uint lanes, float16 in_pixel, int16 bins,
                                        float16 phases, float16 photons) {
  RC_LINE float phase[16], pixels[16], energy[16];
  RC_LINE int bin[16];
  rc_store16(in_pixel, 0, pixels);
  rc_store16(phases, 0, phase);
  rc_store16(as_float16(bins), 0, (float*)bin);
  rc_store16(photons, 0, energy);
  for (; lanes; lanes &= lanes - 1u) {
    const uint k = rc_lowest(lanes);
    rc_deposit(t, rows + (size_t)((uint)pixels[k] * RC_LINES(t) + line) * t->row, sums, bin[k], phase[k], energy[k]);
  }
}

/* Deposits what the live vertices send, `leg` from the end. rows: of the owner, [pixel][line]; kept: moments of its
 * rows, [line], or 0: rows take everything at once (and those of several pixels do). shadow: the ways are traced. */
static inline void rc_connect(SceneArrays scene, const LidarTables* t, const Paths16* paths, const Vertex16* vertex,
                              Leg16 leg, bool shadow, RC_ROW_SPACE float* rows, Moments* kept, LidarSums* sums) {
  global const float4* shot = t->shot;
  global const float* settings = t->settings;
  const Vector16 v = leg.way; /* from the end to the vertex */
  const float16 range = leg.range, inverse = leg.inverse;
  const float16 facing = -rc_dot16(v, vertex->normal) * inverse;
  int16 seen = rc_bits16(paths->live);
  float16 in_pixel;
  const float16 geometry = rc_end_geometry(t, v, inverse, &seen, &in_pixel);
  const uint lanes = rc_mask16(seen & (geometry > 0.0f));
  if (!lanes) return;

  const bool traced = RC_POINTS_OFF(t) && shadow;
  RC_LINE float visible[RC_MOST_LINES][16];
  if (traced) sums->rays += rc_ways_open(scene, t, vertex, v, facing, lanes, visible);

  float16 depth[RC_MOST_LINE_NODES];
  if (RC_MEDIA(t)) rc_depths_home(t, paths, v, range, inverse, lanes, shadow, depth);

  const Vector16 home = {-v.x * inverse, -v.y * inverse, -v.z * inverse};
  Lobes16 lobes;
  if (RC_HAS(t, GLOSS) || RC_HAS(t, SHAPED)) rc_lobes16(t, vertex, paths->way, home, lanes, &lobes);

  const float16 position =
      fma(paths->path + leg.more, (float16)(settings[RC_SET_BINS_PER_M]), (float16)(shot[RC_SHOT_TIME].y));
  const float16 place = rc_min16(rc_max16(position, (float16)(-1e9f)), (float16)(1e9f));
  const int16 cut = convert_int16(place), whole = cut + (convert_float16(cut) > place); /* true is -1 */
  const float16 phases = place - convert_float16(whole);
  const int16 bins = whole + as_int(shot[RC_SHOT_TIME].x);
  const int16 near = (RC_HAS(t, RECEIVER) ? paths->first_range : range) < settings[RC_SET_MINIMUM_RANGE];
  const uint near_lanes = rc_mask16(near) & lanes;

  for (uint line = 0; line < RC_LINES(t); ++line) {
    float16 scatter = rc_matter16(t, vertex, line, 0);
    if (RC_HAS(t, SHAPED))
      scatter *= rc_load16(0, lobes.front[rc_lobe_line(t, line)]);
    else
      scatter *= RC_INVERSE_PI;
    if (RC_HAS(t, GLOSS)) scatter += rc_load16(0, lobes.gloss[rc_lobe_line(t, line)]);
    scatter *= fmax(facing, 0.0f);
    if (RC_HAS(t, LEAVES)) scatter += rc_matter16(t, vertex, line, 1) * RC_INVERSE_PI * fmax(-facing, 0.0f);
    float16 photons = scatter * geometry * paths->weight[line];
    if (RC_MEDIA(t)) photons *= rc_line_transmission(t, line, depth);
    if (traced) photons *= rc_load16(0, visible[line]);
    photons = select((float16)(0.0f), photons, rc_bits16(lanes));
    const uint sent = rc_mask16(photons > 0.0f);
    const bool folded = RC_HAS(t, FOLDED) && kept;
    if (!folded) rc_add_float(sums->sum[line][RC_SUM_COLLECTED], rc_lane_sum(photons));
    if (near_lanes) {
      const float lost = rc_lane_sum(select((float16)(0.0f), photons, near));
      rc_add_float(sums->sum[line][RC_SUM_NEAR], lost);
      if (folded) rc_add_float(sums->sum[line][RC_SUM_COLLECTED], lost);
    }
    if (RC_OWN_PIXELS(t) > 1u) {
      rc_deposit_in_pixels(t, rows, line, sums->sum[line], sent & ~near_lanes, in_pixel, bins, phases, photons);
      continue;
    }
    RC_ROW_SPACE float* row = rows + (size_t)line * t->row;
    if (folded)
      rc_keep_lanes(t, kept + line, row, sums->sum[line], sent & ~near_lanes, bins, phases, photons);
    else
      rc_deposit_lanes(t, row, sums->sum[line], sent & ~near_lanes, bins, phases, photons);
  }
}

#endif
