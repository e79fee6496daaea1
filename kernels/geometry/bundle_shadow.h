/* Points that share a direction (sun, sky), projected to the plane across it, against blocks of 16 triangles set up at
 * once and tested on words of 16 points. Every decision is that of the single-ray test. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_BUNDLE_SHADOW_H
#define RAYCUBE_KERNELS_GEOMETRY_BUNDLE_SHADOW_H

#include "kernels/geometry/bundle.h"

#define RC_BLOCK_COST 4u /* setting up a block, in candidate triangles */
/* Most points of a group, and of their words. Two cache lines more, so that arrays that are read together do not fall
 * into the same sets of a cache. */
#define RC_POINTS (RC_GROUP_WIDTH * RC_MOST_OWN_SIDES * RC_NEAR_SAMPLES + 32)
#define RC_WORD_SLOTS ((RC_POINTS / 16 + 15) / 16 * 16)
typedef struct Points {
  float x[RC_POINTS], y[RC_POINTS], z[RC_POINTS]; /* scene frame, m */
  float a[RC_POINTS], b[RC_POINTS],
      d[RC_POINTS]; /* plane coordinates and distance along the direction, m, about `centre` */
  float lo_a[RC_WORD_SLOTS], hi_a[RC_WORD_SLOTS], lo_b[RC_WORD_SLOTS], hi_b[RC_WORD_SLOTS], lo_d[RC_WORD_SLOTS];
  uint live[RC_WORD_SLOTS];                   /* bits of points that are neither blocked nor out of use */
  uint ground;                                /* an instance that none of their rays meets; RC_NONE: nothing is known */
  uint words, word_slots;                     /* of points; the same rounded up to whole words of words */
  uint costly;                                /* bit t % 32: bundles through tree t did not pay; start with 0 */
  float4 centre, towards, across_a, across_b; /* scene frame; unit vectors */
} RC_LINE Points;

typedef struct Cluster {
  float lo_a, hi_a, lo_b, hi_b, lo_d, reach; /* bounds of the live points; reach: largest coordinate */
} Cluster;

typedef struct ShadowFrame {
  Projection map;
  Ray ray;           /* of the single-ray test; its origin is not used */
  float4 l0, l1, l2; /* local_from_world */
  bool same;         /* the frame is the scene's */
} ShadowFrame;

/* An empty word meets nothing any more. */
static inline void rc_empty_word(Points* points, uint word) {
  points->lo_a[word] = INFINITY;
  points->hi_a[word] = -INFINITY;
}

static inline void rc_word_bounds(Points* points, uint word) {
  const int16 live = rc_bits16(points->live[word]);
  const float16 a = rc_load16(word, points->a), b = rc_load16(word, points->b), d = rc_load16(word, points->d);
  points->lo_a[word] = rc_least16(select((float16)(INFINITY), a, live));
  points->hi_a[word] = rc_most16(select((float16)(-INFINITY), a, live));
  points->lo_b[word] = rc_least16(select((float16)(INFINITY), b, live));
  points->hi_b[word] = rc_most16(select((float16)(-INFINITY), b, live));
  points->lo_d[word] = rc_least16(select((float16)(INFINITY), d, live));
}

/* Projects the points (x, y, z, live and words are set) and bounds their words. */
static inline void rc_project_points(Points* points, float4 towards) {
  const float4 other = fabs(towards.x) < 0.7f ? (float4)(1.0f, 0.0f, 0.0f, 0.0f) : (float4)(0.0f, 1.0f, 0.0f, 0.0f);
  float4 a = rc_cross(towards, other);
  a /= sqrt(rc_dot3(a, a));
  points->towards = towards;
  points->across_a = a;
  points->across_b = rc_cross(towards, a);
  for (uint word = 0; word < points->words; ++word)
    if (points->live[word]) {
      const uint at = word * 16u + rc_lowest(points->live[word]);
      points->centre = (float4)(points->x[at], points->y[at], points->z[at], 0.0f);
      break;
    }
  for (uint word = 0; word < points->words; ++word) {
    const float16 x = rc_load16(word, points->x) - points->centre.x, y = rc_load16(word, points->y) - points->centre.y;
    const float16 z = rc_load16(word, points->z) - points->centre.z;
    rc_store16(rc_project_row(points->across_a, x, y, z), word, points->a);
    rc_store16(rc_project_row(points->across_b, x, y, z), word, points->b);
    rc_store16(rc_project_row(points->towards, x, y, z), word, points->d);
    rc_word_bounds(points, word);
  }
}

static inline Cluster rc_cluster(const Points* points) {
  Cluster c;
  c.lo_a = c.lo_b = c.lo_d = INFINITY;
  c.hi_a = c.hi_b = -INFINITY;
  for (uint word = 0; word < points->words; ++word) {
    c.lo_a = fmin(c.lo_a, points->lo_a[word]);
    c.hi_a = fmax(c.hi_a, points->hi_a[word]);
    c.lo_b = fmin(c.lo_b, points->lo_b[word]);
    c.hi_b = fmax(c.hi_b, points->hi_b[word]);
    c.lo_d = fmin(c.lo_d, points->lo_d[word]);
  }
  c.reach = fmax(fmax(fmax(-c.lo_a, c.hi_a), fmax(-c.lo_b, c.hi_b)), -c.lo_d);
  return c;
}

static inline float4 rc_row_of(float4 e, float4 w0, float4 w1, float4 w2) {
  return (float4)(fma(e.x, w0.x, fma(e.y, w1.x, e.z * w2.x)), fma(e.x, w0.y, fma(e.y, w1.y, e.z * w2.y)),
                  fma(e.x, w0.z, fma(e.y, w1.z, e.z * w2.z)), 0.0f);
}

/* Errors in m, of this map and of the single-ray test together. In the scene's frame only differences and their
 * products with unit rows are rounded: 5 ulp of a length here and 4 there, lengths being at most sqrt(3) times the
 * largest coordinate:
 * 16 ulp of the vertex, 10 of the point. In another frame the centre's and the point's maps (4 roundings each of sums
 * of absolute products), mapped back, and both matrices' own rounding come on top: 12 ulp of those sums; and the
 * vertex's error is multiplied by the matrices' condition. `extent` (m) bounds the mesh across the direction: the
 * single-ray test lets in rays within 4.3 ulp of a triangle's longest edge (box_ray.h), which the planes must hold
 * too: 8 ulp. */
__attribute__((noinline)) static void rc_frame_bundle(const Points* points, const Cluster* cluster,
                                                      global const Instance* placed, float extent, ShadowFrame* frame,
                                                      Cull* cull) {
  const float4 w0 = placed->world_from_local_0, w1 = placed->world_from_local_1, w2 = placed->world_from_local_2;
  frame->map.error_square = 0.0f;
  if (frame->same) {
    frame->map.origin = points->centre;
    frame->map.a = points->across_a;
    frame->map.b = points->across_b;
    frame->map.z = points->towards;
    frame->map.error = 10.0f * RC_ULP * cluster->reach;
    frame->map.error_growth = 16.0f * RC_ULP;
  } else {
    frame->map.origin = rc_map_point(frame->l0, frame->l1, frame->l2, points->centre);
    frame->map.a = rc_row_of(points->across_a, w0, w1, w2);
    frame->map.b = rc_row_of(points->across_b, w0, w1, w2);
    frame->map.z = rc_row_of(points->towards, w0, w1, w2);
    const float4 far = fabs(points->centre) + (float4)(cluster->reach * 2.0f);
    const float4 size = rc_map_sizes(frame->l0, frame->l1, frame->l2, far);
    const float4 rows = (float4)(rc_map_size(fabs((float4)(frame->l0.xyz, 0.0f)), (float4)(1.0f)),
                                 rc_map_size(fabs((float4)(frame->l1.xyz, 0.0f)), (float4)(1.0f)),
                                 rc_map_size(fabs((float4)(frame->l2.xyz, 0.0f)), (float4)(1.0f)), 0.0f);
    const float4 columns = fabs((float4)(w0.xyz, 0.0f)) + fabs((float4)(w1.xyz, 0.0f)) + fabs((float4)(w2.xyz, 0.0f));
    frame->map.error = RC_ULP * fma(12.0f, rc_dot3(columns, size), 10.0f * cluster->reach);
    frame->map.error_growth = 16.0f * RC_ULP * rc_dot3(columns, rows);
  }
  const float slack = fma(8.0f * RC_ULP, extent, fma(frame->map.error_growth, cluster->reach, frame->map.error));
  const float4 widen = frame->map.error_growth * frame->map.z;
  cull->ox = frame->map.origin.x;
  cull->oy = frame->map.origin.y;
  cull->oz = frame->map.origin.z;
  rc_set_plane(cull, 0, widen + frame->map.a, slack - cluster->lo_a);
  rc_set_plane(cull, 1, widen - frame->map.a, slack + cluster->hi_a);
  rc_set_plane(cull, 2, widen + frame->map.b, slack - cluster->lo_b);
  rc_set_plane(cull, 3, widen - frame->map.b, slack + cluster->hi_b);
  rc_set_plane(cull, 4, frame->map.z, slack - cluster->lo_d);
}

/* The frame of the single-ray tests in a placed mesh. */
static inline void rc_frame_rays(const Points* points, global const Instance* placed, ShadowFrame* frame) {
  frame->l0 = placed->local_from_world_0;
  frame->l1 = placed->local_from_world_1;
  frame->l2 = placed->local_from_world_2;
  frame->same = placed->flags & 1u;
  frame->ray = rc_make_ray(
      points->centre, frame->same ? points->towards : rc_map_vector(frame->l0, frame->l1, frame->l2, points->towards));
}

/* The single-ray test of one triangle for 16 points: bit i = point i is blocked. */
static inline uint rc_block_word(const ShadowFrame* frame, const Points* points, uint word,
                                 global const TriBlock* block, uint lane) {
  global const float* at = (global const float*)block + lane;
  const float16 wx = rc_load16(word, points->x), wy = rc_load16(word, points->y), wz = rc_load16(word, points->z);
  float16 from[3];
  if (frame->same) {
    from[0] = wx;
    from[1] = wy;
    from[2] = wz;
  } else {
    const float4 l0 = frame->l0, l1 = frame->l1, l2 = frame->l2;
    from[0] = fma((float16)(l0.x), wx, fma((float16)(l0.y), wy, fma((float16)(l0.z), wz, (float16)(l0.w))));
    from[1] = fma((float16)(l1.x), wx, fma((float16)(l1.y), wy, fma((float16)(l1.z), wz, (float16)(l1.w))));
    from[2] = fma((float16)(l2.x), wx, fma((float16)(l2.y), wy, fma((float16)(l2.z), wz, (float16)(l2.w))));
  }
  const int x = 16 * frame->ray.kx, y = 16 * frame->ray.ky, z = 16 * frame->ray.kz;
  const float16 o[3] = {from[frame->ray.kx], from[frame->ray.ky], from[frame->ray.kz]};
  const float16 a[3] = {(float16)(at[x]), (float16)(at[y]), (float16)(at[z])};
  const float16 b[3] = {(float16)(at[48 + x]), (float16)(at[48 + y]), (float16)(at[48 + z])};
  const float16 c[3] = {(float16)(at[96 + x]), (float16)(at[96 + y]), (float16)(at[96 + z])};
  float16 t;
  return rc_hit_pairs(a, b, c, o, 0, (float16)(frame->ray.sx), (float16)(frame->ray.sy), (float16)(frame->ray.sz), &t);
}

static inline bool rc_points_left(const Points* points) {
  uint left = 0;
  for (uint word = 0; word < points->words; ++word) left |= points->live[word];
  return left != 0u;
}

/* Clears the bits of points that the block's triangles hide. Returns what it cost, in candidates. */
__attribute__((noinline)) static uint rc_shadow_block(const ShadowFrame* frame, const Cluster* cluster, Points* points,
                                                      global const TriBlock* block) {
  const Setup s = rc_setup_block(&frame->map, block, false);
  const float16 depth_band = fma(s.band, fabs(s.q1) + fabs(s.q2), 2.0f * s.error);
  const float16 hi_d = rc_max16(s.q0, rc_max16(s.q0 + s.q1, s.q0 + s.q2)) + depth_band;
  uint lanes = rc_mask16(s.usable & (s.lo_a <= cluster->hi_a) & (s.hi_a >= cluster->lo_a) & (s.lo_b <= cluster->hi_b) &
                         (s.hi_b >= cluster->lo_b) & (hi_d >= cluster->lo_d));
  if (!lanes) return RC_BLOCK_COST;
  const uint cost = RC_BLOCK_COST + popcount(lanes);
  RC_LINE float depth_bands[16], depths[16];
  LaneForms form;
  LaneRectangles box;
  rc_store_forms(&s, &form);
  rc_store_rectangles(&s, &box);
  rc_store16(depth_band, 0, depth_bands);
  rc_store16(hi_d, 0, depths);
  for (; lanes; lanes &= lanes - 1u) {
    const uint lane = rc_lowest(lanes);
    const float16 band = form.band[lane], depth = depth_bands[lane];
    for (uint base = 0; base < points->words; base += 32u) {
      uint touched = 0; /* of 32 words: one loop of unforeseeable length, not two */
      for (uint first = 0; first < 32u && base + first < points->word_slots; first += 16u) {
        const uint at = base + first;
        touched |= rc_mask16((rc_load16(0, points->lo_a + at) <= box.hi_a[lane]) &
                             (rc_load16(0, points->hi_a + at) >= box.lo_a[lane]) &
                             (rc_load16(0, points->lo_b + at) <= box.hi_b[lane]) &
                             (rc_load16(0, points->hi_b + at) >= box.lo_b[lane]) &
                             (rc_load16(0, points->lo_d + at) <= depths[lane]))
                   << first;
      }
      for (; touched; touched &= touched - 1u) {
        const uint word = base + rc_lowest(touched);
        const float16 a = rc_load16(word, points->a), b = rc_load16(word, points->b), d = rc_load16(word, points->d);
        const float16 l1 =
            fma((float16)(form.l1a[lane]), a, fma((float16)(form.l1b[lane]), b, (float16)(form.l1c[lane])));
        const float16 l2 =
            fma((float16)(form.l2a[lane]), a, fma((float16)(form.l2b[lane]), b, (float16)(form.l2c[lane])));
        const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2);
        const float16 gap =
            fma(l1, (float16)(form.q1[lane]), fma(l2, (float16)(form.q2[lane]), (float16)(form.q0[lane]))) - d;
        const uint maybe = rc_mask16((least >= -band) & (gap >= -depth)) & points->live[word];
        if (!maybe) continue;
        uint dark = rc_mask16((least > band) & (gap > depth)) & maybe;
        if (dark != maybe) dark |= rc_block_word(frame, points, word, block, lane) & maybe;
        if (!dark) continue;
        points->live[word] &= ~dark;
        if (!points->live[word]) rc_empty_word(points, word);
      }
    }
  }
  return cost;
}

#endif
