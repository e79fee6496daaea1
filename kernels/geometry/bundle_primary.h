/* A group's primary rays, all from one origin, through one traversal. Leaves: 16 triangles are projected to the image plane
 * at once and dropped unless a sample lies in their rectangle; small ones (at most 3 x 3 samples) are tested with triangles
 * as lanes, large ones with a tile of 4 x 4 samples as lanes. Samples off the grid (RC_SCATTER) go by words of 16. A buffer of
 * 1 / t and ids, one slot per sample, keeps the closest. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_BUNDLE_PRIMARY_H
#define RAYCUBE_KERNELS_GEOMETRY_BUNDLE_PRIMARY_H

#include "kernels/geometry/bundle.h"
#include "kernels/geometry/samples.h"

/* Half the field that a group's samples cover, pixels. */
#define RC_HALF_A (0.5f * (float)(RC_GROUP_PIXELS - 1) + 0.5f * RC_SUPPORT)
#define RC_HALF_B (0.5f * RC_SUPPORT)

#if !RC_SCATTER
/* Sample grid of a group: the pixels of a line side by side, kept in tiles of 4 x 4 samples, four tiles at a time. */
#define RC_GRID_COLUMNS (RC_GROUP_PIXELS * RC_NU)
#define RC_GRID_ROWS (RC_CHUNK / RC_NU)
#define RC_TILE_COLUMNS ((RC_GRID_COLUMNS + 15) / 16 * 4)
#define RC_TILE_ROWS ((RC_GRID_ROWS + 3) / 4)
#define RC_SMALL 3
#define RC_SLOTS (16 * RC_TILE_COLUMNS * RC_TILE_ROWS)
#else
/* Samples anywhere in the field: pixel p's sample k has slot p * RC_NPAD + k; words of 16 carry their bounds. */
#define RC_SLOTS (RC_GROUP_PIXELS * RC_NPAD)
#define RC_SAMPLE_WORDS (RC_SLOTS / 16)
#define RC_BOUND_SLOTS ((RC_SAMPLE_WORDS + 15) / 16 * 16)
typedef struct Scatter {
  float a[RC_SLOTS], b[RC_SLOTS];  /* INFINITY: no sample */
  float lo_a[RC_BOUND_SLOTS], hi_a[RC_BOUND_SLOTS], lo_b[RC_BOUND_SLOTS], hi_b[RC_BOUND_SLOTS];
} Scatter;
#endif

typedef struct Closest {
  float near[RC_SLOTS];                          /* 1 / t of the closest hit; 0: none */
  uint instance[RC_SLOTS], primitive[RC_SLOTS];  /* set where there is a hit */
} RC_LINE Closest;

/* The group in the frame of one instance (or of the scene). */
typedef struct GroupFrame {
  RayGroup rays;               /* in this frame, for the projection */
  RayGroup world;              /* in the scene frame: a single ray is made there and then mapped, as rc_trace_ray does */
  float4 l0, l1, l2;           /* local_from_world */
  bool same;                   /* the frame is the scene's */
  Projection map;
#if RC_SCATTER
  const Scatter* samples;
#else
  uint first_row, rows;  /* of the chunk */
  uint columns;          /* of the pixels that exist */
#endif
} GroupFrame;

/* Samples that the linear forms leave open, each with a triangle of the frame's mesh: decided 16 at a time. */
typedef struct Open {
  uint primitive[16], sample[16];  /* sample: slot (RC_SCATTER), or row * 65536 + column */
  uint count;
} Open;

static inline float4 rc_sum_products(float4 x, float4 y) { return fabs(x) * fabs(y); }
static inline float rc_sum3(float4 v) { return v.x + v.y + v.z; }

/* Direction of a sample's single ray in the frame: the very operations of rc_trace_instance. */
static inline float4 rc_frame_direction(const GroupFrame* frame, float a, float b) {
  const float4 direction = rc_group_direction(frame->world, a, b);
  return frame->same ? direction : rc_map_vector(frame->l0, frame->l1, frame->l2, direction);
}

/* Largest components of the directions in the group's field. */
static inline float4 rc_field(RayGroup g) { return fabs(g.d0) + RC_HALF_A * fabs(g.du) + RC_HALF_B * fabs(g.dv); }

/* Dual basis of (du, dv, d0): p = z (d0 + a du + b dv). Errors, in pixels, of a and b at points inside the group's field, for
 * this map and for the single-ray test together: rows 3 ulp, sum of products 3 ulp; there the direction 3, its shear 3, the
 * moved vertex 1, and 3 in reserve: 16 ulp of the sum of absolute products. In the frame of an instance the three basis vectors
 * are mapped here and every direction there, 3 ulp each of the absolute products with the matrix, as is their sum: 24 ulp. */
static inline void rc_frame_group(GroupFrame* frame, Cull* cull) {
  const float4 du = frame->rays.du, dv = frame->rays.dv, d0 = frame->rays.d0;
  const float4 a = rc_cross(dv, d0), b = rc_cross(d0, du), z = rc_cross(du, dv);
  const float scale = 1.0f / rc_dot3(d0, z);
  frame->map.origin = frame->rays.origin;
  frame->map.a = a * scale;
  frame->map.b = b * scale;
  frame->map.z = z * scale;
  const float half_a = RC_HALF_A, half_b = RC_HALF_B;
  const float4 span = fabs(du) + fabs(dv);
  const float4 field = frame->same ? rc_field(frame->rays) : rc_map_vector(fabs(frame->l0), fabs(frame->l1), fabs(frame->l2), rc_field(frame->world));
  const float size = fmax(rc_sum3(rc_sum_products(frame->map.a, field)), rc_sum3(rc_sum_products(frame->map.b, field)));
  const float depth = rc_sum3(rc_sum_products(frame->map.z, field));
  const float growth = fmax(rc_sum3(rc_sum_products(frame->map.a, span)), rc_sum3(rc_sum_products(frame->map.b, span))) + depth;
  frame->map.error = (frame->same ? 16.0f : 24.0f) * RC_ULP * (size + half_a * depth);
  frame->map.error_growth = 32.0f * RC_ULP * growth;
  frame->map.error_square = 32.0f * RC_ULP * rc_sum3(rc_sum_products(frame->map.z, span));
  /* A thousandth of a pixel for the single-ray test, which lets in rays within 1.5 ulp of a long edge (ray_trace.h). */
  const float edge_a = half_a + 2.0f * frame->map.error + 1e-3f, edge_b = half_b + 2.0f * frame->map.error + 1e-3f;
  cull->ox = frame->rays.origin.x;
  cull->oy = frame->rays.origin.y;
  cull->oz = frame->rays.origin.z;
  rc_set_plane(cull, 0, edge_a * frame->map.z - frame->map.a, 0.0f);
  rc_set_plane(cull, 1, edge_a * frame->map.z + frame->map.a, 0.0f);
  rc_set_plane(cull, 2, edge_b * frame->map.z - frame->map.b, 0.0f);
  rc_set_plane(cull, 3, edge_b * frame->map.z + frame->map.b, 0.0f);
}

/* Keeps the larger 1 / t; of equal ones the lower instance, then the lower primitive. */
static inline void rc_keep(Closest* closest, uint slot, float near, uint instance, uint primitive) {
  const bool first = near == closest->near[slot] &&
                     (instance < closest->instance[slot] || (instance == closest->instance[slot] && primitive < closest->primitive[slot]));
  if (near > closest->near[slot] || first) {
    closest->near[slot] = near;
    closest->instance[slot] = instance;
    closest->primitive[slot] = primitive;
  }
}

/* Of the lanes that have no linear form, those that the group can see: not all behind, not all beyond one side. */
static inline uint rc_behind(const GroupFrame* frame, global const TriBlock* block, int16 lanes) {
  global const float* at = (global const float*)block;
  const float edge_a = RC_HALF_A + 2.0f * frame->map.error, edge_b = RC_HALF_B + 2.0f * frame->map.error;
  int16 back = -1, left = -1, right = -1, above = -1, below = -1;
  for (int i = 0; i < 3; ++i) {
    const float16 x = vload16(0, at + 48 * i) - frame->map.origin.x, y = vload16(0, at + 48 * i + 16) - frame->map.origin.y;
    const float16 z = vload16(0, at + 48 * i + 32) - frame->map.origin.z;
    const float16 a = rc_project_row(frame->map.a, x, y, z), b = rc_project_row(frame->map.b, x, y, z), depth = rc_project_row(frame->map.z, x, y, z);
    const float16 slack = (fabs(a) + fabs(b) + fabs(depth)) * (frame->map.error + frame->map.error_growth);
    back &= depth <= 0.0f;
    left &= fma((float16)(edge_a), depth, a) < -slack;
    right &= fma((float16)(edge_a), depth, -a) < -slack;
    above &= fma((float16)(edge_b), depth, b) < -slack;
    below &= fma((float16)(edge_b), depth, -b) < -slack;
  }
  return rc_mask16(lanes & ~(back | left | right | above | below));
}

#if RC_SCATTER
static inline uint rc_open_slot(uint sample) { return sample; }
static inline void rc_open_position(const GroupFrame* frame, uint sample, float* a, float* b) {
  *a = frame->samples->a[sample];
  *b = frame->samples->b[sample];
}
#else
/* Slot of a sample of the chunk. */
static inline uint rc_slot(uint row, uint column) {
  return (row / 4u * RC_TILE_COLUMNS + column / 4u) * 16u + row % 4u * 4u + column % 4u;
}
static inline uint rc_open_slot(uint sample) { return rc_slot(sample >> 16, sample & 0xffffu); }
static inline void rc_open_position(const GroupFrame* frame, uint sample, float* a, float* b) {
  const uint row = sample >> 16, column = sample & 0xffffu, p = column / RC_NU;
  rc_group_sample(0u, 0u, p, (frame->first_row + row) * RC_NU + column - p * RC_NU, a, b);
}
#endif

/* Decides the open samples by the single-ray test and empties the list. */
__attribute__((noinline)) static void rc_decide(SceneArrays scene, const GroupFrame* frame, Closest* closest, uint instance, Open* open) {
  RC_LINE float corner[9][16], direction[3][16];
  for (uint k = 0; k < open->count; ++k) {
    global const float* at = (global const float*)rc_block(scene, open->primitive[k] / RC_BLOCK) + open->primitive[k] % RC_BLOCK;
    #pragma unroll
    for (uint i = 0; i < 9u; ++i) corner[i][k] = at[16u * i];
    float a, b;
    rc_open_position(frame, open->sample[k], &a, &b);
    const float4 d = rc_frame_direction(frame, a, b);
    direction[0][k] = d.x;
    direction[1][k] = d.y;
    direction[2][k] = d.z;
  }
  /* Each ray's own axes, as rc_make_ray takes them. */
  const float16 dx = vload16(0, direction[0]), dy = vload16(0, direction[1]), dz = vload16(0, direction[2]);
  const int16 z_first = (fabs(dz) >= fabs(dx)) & (fabs(dz) >= fabs(dy)), y_first = fabs(dy) >= fabs(dx);
  float16 v[5][3];  /* corners, origin, direction */
  #pragma unroll
  for (uint i = 0; i < 5u; ++i) {
    const float4 o = frame->rays.origin;
    const float16 x = i < 3u ? vload16(0, corner[3u * i % 9u]) : i == 3u ? (float16)(o.x) : dx;
    const float16 y = i < 3u ? vload16(0, corner[(3u * i + 1u) % 9u]) : i == 3u ? (float16)(o.y) : dy;
    const float16 z = i < 3u ? vload16(0, corner[(3u * i + 2u) % 9u]) : i == 3u ? (float16)(o.z) : dz;
    v[i][0] = select(select(y, z, y_first), x, z_first);
    v[i][1] = select(select(z, x, y_first), y, z_first);
    v[i][2] = select(select(x, y, y_first), z, z_first);
  }
  float16 t;
  uint hits = rc_hit_pairs(v[0], v[1], v[2], v[3], v[4][0] / v[4][2], v[4][1] / v[4][2], 1.0f / v[4][2], &t) & ((1u << open->count) - 1u);
  open->count = 0;
  if (!hits) return;
  RC_LINE float near[16];
  rc_store16(1.0f / t, 0, near);
  for (; hits; hits &= hits - 1u) {
    const uint k = rc_lowest(hits);
    rc_keep(closest, rc_open_slot(open->sample[k]), near[k], instance, open->primitive[k]);
  }
}

static inline void rc_leave_open(SceneArrays scene, const GroupFrame* frame, Closest* closest, uint instance, Open* open, uint primitive, uint sample) {
  open->primitive[open->count] = primitive;
  open->sample[open->count] = sample;
  if (++open->count == 16u) rc_decide(scene, frame, closest, instance, open);
}

/* How far above its linear form a triangle's 1 / t may lie by the single-ray test, on samples that may belong to it: what the
 * form moves in the band outside, and 64 roundings of the farthest corner's distance. An open sample whose 1 / t stays below
 * what is kept already needs no decision. */
static inline float16 rc_near_slack(const Setup* s) {
  const float16 q1 = s->q0 + s->q1, q2 = s->q0 + s->q2;
  const float16 most = rc_max16(s->q0, rc_max16(q1, q2)), least = rc_min16(s->q0, rc_min16(q1, q2));
  return fma(2.0f * s->band, fabs(s->q1) + fabs(s->q2), 64.0f * RC_ULP * most * (most / least));
}

#if RC_SCATTER
static inline void rc_primary_block(SceneArrays scene, const GroupFrame* frame, Closest* closest, Open* open, uint index, uint instance) {
  global const TriBlock* block = rc_block(scene, index);
  const uint first = index * RC_BLOCK;
  const Setup s = rc_setup_block(&frame->map, block, true);
  const Scatter* samples = frame->samples;
  uint lanes = rc_mask16(s.usable & (s.lo_a <= RC_HALF_A) & (s.hi_a >= -RC_HALF_A) & (s.lo_b <= RC_HALF_B) & (s.hi_b >= -RC_HALF_B));
  const uint behind_bits = rc_mask16(s.behind) ? rc_behind(frame, block, s.behind) : 0u;
  if (!(lanes | behind_bits)) return;
  RC_LINE float slack[16];
  rc_store16(rc_near_slack(&s), 0, slack);
  RC_LINE float l1a[16], l1b[16], l1c[16], l2a[16], l2b[16], l2c[16], q0[16], q1[16], q2[16], bands[16], lo_a[16], hi_a[16], lo_b[16], hi_b[16];
  rc_store16(s.l1a, 0, l1a);
  rc_store16(s.l1b, 0, l1b);
  rc_store16(s.l1c, 0, l1c);
  rc_store16(s.l2a, 0, l2a);
  rc_store16(s.l2b, 0, l2b);
  rc_store16(s.l2c, 0, l2c);
  rc_store16(s.q0, 0, q0);
  rc_store16(s.q1, 0, q1);
  rc_store16(s.q2, 0, q2);
  rc_store16(s.band, 0, bands);
  rc_store16(s.lo_a, 0, lo_a);
  rc_store16(s.hi_a, 0, hi_a);
  rc_store16(s.lo_b, 0, lo_b);
  rc_store16(s.hi_b, 0, hi_b);
  for (; lanes; lanes &= lanes - 1u) {
    const uint lane = rc_lowest(lanes);
    const float16 band = bands[lane];
    for (uint base = 0; base < RC_SAMPLE_WORDS; base += 16u) {
      uint touched = rc_mask16((vload16(0, samples->lo_a + base) <= hi_a[lane]) & (vload16(0, samples->hi_a + base) >= lo_a[lane]) &
                               (vload16(0, samples->lo_b + base) <= hi_b[lane]) & (vload16(0, samples->hi_b + base) >= lo_b[lane]));
      for (; touched; touched &= touched - 1u) {
        const uint slot = (base + rc_lowest(touched)) * 16u;
        const float16 a = vload16(0, samples->a + slot), b = vload16(0, samples->b + slot);
        const float16 l1 = fma((float16)(l1a[lane]), a, fma((float16)(l1b[lane]), b, (float16)(l1c[lane])));
        const float16 l2 = fma((float16)(l2a[lane]), a, fma((float16)(l2b[lane]), b, (float16)(l2c[lane])));
        const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2);
        const int16 exists = (a < INFINITY) & (least >= -band);
        if (!rc_mask16(exists)) continue;
        const float16 near = fma(l1, (float16)(q1[lane]), fma(l2, (float16)(q2[lane]), (float16)(q0[lane])));
        const float16 before = vload16(0, closest->near + slot);
        const int16 inside = exists & (least > band), nearer = inside & (near > before);
        if (rc_mask16(nearer)) {
          rc_store16(select(before, near, nearer), 0, closest->near + slot);
          rc_store16(select(vload16(0, closest->instance + slot), (uint16)(instance), nearer), 0, closest->instance + slot);
          rc_store16(select(vload16(0, closest->primitive + slot), (uint16)(first + lane), nearer), 0, closest->primitive + slot);
        }
        uint rest = rc_mask16(exists & (~inside | (near == before)) & (near + slack[lane] >= before));
        if (!rest) continue;
        const uint tied = rc_mask16(inside);
        RC_LINE float near_of[16];
        rc_store16(near, 0, near_of);
        for (; rest; rest &= rest - 1u) {
          const uint k = rc_lowest(rest);
          if (tied >> k & 1u) rc_keep(closest, slot + k, near_of[k], instance, first + lane);
          else rc_leave_open(scene, frame, closest, instance, open, first + lane, slot + k);
        }
      }
    }
  }
  for (uint rest = behind_bits; rest; rest &= rest - 1u)  /* crosses the sensor's plane: every sample alone */
    for (uint slot = 0; slot < RC_SLOTS; ++slot)
      if (samples->a[slot] < INFINITY) rc_leave_open(scene, frame, closest, instance, open, first + rc_lowest(rest), slot);
}

/* Positions of samples first .. first + count - 1 of the group's pixels, and the bounds of their words. */
static inline void rc_scatter_samples(Scatter* samples, uint seed, GroupPlace place, uint first, uint count) {
  for (uint p = 0; p < RC_GROUP_PIXELS; ++p)
    for (uint k = 0; k < RC_NPAD; ++k) {
      float a = INFINITY, b = INFINITY;
      if (p < place.used && k < count) rc_group_sample(seed, place.number + p, p, first + k, &a, &b);
      samples->a[p * RC_NPAD + k] = a;
      samples->b[p * RC_NPAD + k] = b;
    }
  for (uint word = 0; word < RC_BOUND_SLOTS; ++word) {
    float lo_a = INFINITY, hi_a = -INFINITY, lo_b = INFINITY, hi_b = -INFINITY;
    for (uint k = 0; word < RC_SAMPLE_WORDS && k < 16u; ++k) {
      const float a = samples->a[word * 16u + k], b = samples->b[word * 16u + k];
      if (!(a < INFINITY)) continue;
      lo_a = fmin(lo_a, a);
      hi_a = fmax(hi_a, a);
      lo_b = fmin(lo_b, b);
      hi_b = fmax(hi_b, b);
    }
    samples->lo_a[word] = lo_a;
    samples->hi_a[word] = hi_a;
    samples->lo_b[word] = lo_b;
    samples->hi_b[word] = hi_b;
  }
}

#else
/* Image-plane coordinates of a column and of a row of the whole pixel. */
static inline float16 rc_column_a(float16 column) {
  return fma(column, (float16)(1.0f / RC_NU), (float16)(0.5f / RC_NU - 0.5f * RC_GROUP_PIXELS));
}
static inline float16 rc_row_b(float16 row) { return fma(row, (float16)(1.0f / RC_NV), (float16)(0.5f / RC_NV - 0.5f)); }

static inline void rc_primary_block(SceneArrays scene, const GroupFrame* frame, Closest* closest, Open* open, uint index, uint instance) {
  global const TriBlock* block = rc_block(scene, index);
  const uint first = index * RC_BLOCK;
  const Setup s = rc_setup_block(&frame->map, block, true);
  /* Samples inside each rectangle: first and last column and row. The 1e-5 covers the rounding of these four lines. */
  const float16 left = rc_max16(ceil(fma(s.lo_a, (float16)(RC_NU), (float16)(0.5f * RC_GRID_COLUMNS - 0.5f - 1e-5f))), (float16)(0.0f));
  const float16 right = rc_min16(floor(fma(s.hi_a, (float16)(RC_NU), (float16)(0.5f * RC_GRID_COLUMNS - 0.5f + 1e-5f))), (float16)((float)frame->columns - 1.0f));
  const float row_shift = 0.5f * RC_NV - 0.5f - (float)frame->first_row;
  const float16 above = rc_max16(ceil(fma(s.lo_b, (float16)(RC_NV), (float16)(row_shift - 1e-5f))), (float16)(0.0f));
  const float16 below = rc_min16(floor(fma(s.hi_b, (float16)(RC_NV), (float16)(row_shift + 1e-5f))), (float16)((float)(frame->rows - 1u)));
  const float16 columns = right - left, rows = below - above;
  const int16 seen = s.usable & (columns >= 0.0f) & (rows >= 0.0f);
  const uint seen_bits = rc_mask16(seen);
  const uint behind_bits = rc_mask16(s.behind) ? rc_behind(frame, block, s.behind) : 0u;
  if (!(seen_bits | behind_bits)) return;
  const int16 small = seen & (columns < (float)RC_SMALL) & (rows < (float)RC_SMALL);
  const uint small_bits = rc_mask16(small);
  uint large_bits = seen_bits & ~small_bits;
  RC_LINE uint left_of[16], above_of[16];
  rc_store16(convert_uint16(left), 0, left_of);
  rc_store16(convert_uint16(above), 0, above_of);
  const float16 slack = rc_near_slack(&s);

  if (small_bits) {
    #pragma unroll 1
    for (int r = 0; r < RC_SMALL; ++r) {
      const int16 in_row = small & (rows >= (float)r);
      if (!rc_mask16(in_row)) break;
      const float16 b = rc_row_b(above + ((float)frame->first_row + (float)r));
      #pragma unroll 1
      for (int c = 0; c < RC_SMALL; ++c) {
        const int16 in_cell = in_row & (columns >= (float)c);
        const float16 a = rc_column_a(left + (float)c);
        const float16 l1 = fma(s.l1a, a, fma(s.l1b, b, s.l1c)), l2 = fma(s.l2a, a, fma(s.l2b, b, s.l2c));
        const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2);
        uint bits = rc_mask16(in_cell & (least >= -s.band));
        if (!bits) continue;
        const uint undecided = rc_mask16(least <= s.band);
        const float16 here = fma(l1, s.q1, fma(l2, s.q2, s.q0));
        RC_LINE float near[16], near_most[16];
        rc_store16(here, 0, near);
        rc_store16(here + slack, 0, near_most);
        while (bits) {
          const uint lane = rc_lowest(bits), row = above_of[lane] + r, column = left_of[lane] + c, slot = rc_slot(row, column);
          bits &= bits - 1u;
          if (!(undecided >> lane & 1u)) rc_keep(closest, slot, near[lane], instance, first + lane);
          else if (near_most[lane] >= closest->near[slot]) rc_leave_open(scene, frame, closest, instance, open, first + lane, row << 16 | column);
        }
      }
    }
  }

  if (large_bits) {
    RC_LINE float l1a[16], l1b[16], l1c[16], l2a[16], l2b[16], l2c[16], q0[16], q1[16], q2[16], band[16], slack_of[16];
    RC_LINE uint right_of[16], below_of[16];
    rc_store16(s.l1a, 0, l1a);
    rc_store16(s.l1b, 0, l1b);
    rc_store16(s.l1c, 0, l1c);
    rc_store16(s.l2a, 0, l2a);
    rc_store16(s.l2b, 0, l2b);
    rc_store16(s.l2c, 0, l2c);
    rc_store16(s.q0, 0, q0);
    rc_store16(s.q1, 0, q1);
    rc_store16(s.q2, 0, q2);
    rc_store16(s.band, 0, band);
    rc_store16(slack, 0, slack_of);
    rc_store16(convert_uint16(right), 0, right_of);
    rc_store16(convert_uint16(below), 0, below_of);
    const float16 lane_column = (float16)(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
    const float16 lane_row = (float16)(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3) + (float)frame->first_row;
    while (large_bits) {
      const uint lane = rc_lowest(large_bits);
      large_bits &= large_bits - 1u;
      const uint first_column = left_of[lane] / 4u, last_column = right_of[lane] / 4u, last_row = below_of[lane] / 4u;
      const float16 uncertain = band[lane];
      for (uint tile_row = above_of[lane] / 4u; tile_row <= last_row; ++tile_row) {
        const float16 b = rc_row_b(lane_row + (float)(4u * tile_row));
        float16 column_of = lane_column + (float)(4u * first_column);
        const float16 l1_row = fma((float16)(l1b[lane]), b, (float16)(l1c[lane])), l2_row = fma((float16)(l2b[lane]), b, (float16)(l2c[lane]));
        for (uint tile_column = first_column; tile_column <= last_column; ++tile_column, column_of += 4.0f) {
          const uint slot = (tile_row * RC_TILE_COLUMNS + tile_column) * 16u;
          const float16 a = rc_column_a(column_of);
          const float16 l1 = fma((float16)(l1a[lane]), a, l1_row), l2 = fma((float16)(l2a[lane]), a, l2_row);
          const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2);
          const float16 near = fma(l1, (float16)(q1[lane]), fma(l2, (float16)(q2[lane]), (float16)(q0[lane])));
          const float16 before = vload16(0, closest->near + slot);
          const int16 inside = least > uncertain, nearer = inside & (near > before);
          uint rest = rc_mask16((least >= -uncertain) & (~inside | (near == before)));
          rc_store16(select(before, near, nearer), 0, closest->near + slot);
          rc_store16(select(vload16(0, closest->instance + slot), (uint16)(instance), nearer), 0, closest->instance + slot);
          rc_store16(select(vload16(0, closest->primitive + slot), (uint16)(first + lane), nearer), 0, closest->primitive + slot);
          if (rest) {
            rest &= rc_mask16(near + slack_of[lane] >= before);
            const uint tied = rc_mask16(inside);
            RC_LINE float near_of[16];
            rc_store16(near, 0, near_of);
            for (; rest; rest &= rest - 1u) {
              const uint k = rc_lowest(rest), row = tile_row * 4u + k / 4u, column = tile_column * 4u + k % 4u;
              if (row >= frame->rows || column >= frame->columns) continue;
              if (tied >> k & 1u) rc_keep(closest, slot + k, near_of[k], instance, first + lane);
              else rc_leave_open(scene, frame, closest, instance, open, first + lane, row << 16 | column);
            }
          }
        }
      }
    }
  }

  for (uint lanes = behind_bits; lanes; lanes &= lanes - 1u) {  /* crosses the sensor's plane: every sample alone */
    const uint lane = rc_lowest(lanes);
    for (uint row = 0; row < frame->rows; ++row)
      for (uint column = 0; column < frame->columns; ++column)
        rc_leave_open(scene, frame, closest, instance, open, first + lane, row << 16 | column);
  }
}

/* From the tiles of a group to the slots of its pixels, by way of whole rows; samples without a hit and empty slots become
 * RC_NONE. Each step reads what the one before has long written: a load that spans fresh stores waits for them. */
static inline void rc_write_pixels(const float* near, const uint* tiles, uint used, uint rows, global uint* out, size_t stride) {
  RC_LINE uint lines[RC_TILE_ROWS * RC_TILE_COLUMNS * 16 + 16], slots[RC_GROUP_PIXELS * RC_NPAD + 16];
  for (uint tile = 0; tile < RC_TILE_ROWS * RC_TILE_COLUMNS; tile += 4u) {
    uint16 t[4];
    #pragma unroll
    for (uint i = 0; i < 4u; ++i) t[i] = select(vload16(tile + i, tiles), (uint16)(RC_NONE), vload16(tile + i, near) == 0.0f);
    uint* line = lines + (tile / RC_TILE_COLUMNS * (RC_TILE_COLUMNS * 4u) + tile % RC_TILE_COLUMNS) * 4u;
    rc_store16((uint16)(t[0].s0123, t[1].s0123, t[2].s0123, t[3].s0123), 0, line);
    rc_store16((uint16)(t[0].s4567, t[1].s4567, t[2].s4567, t[3].s4567), 0, line + RC_TILE_COLUMNS * 4);
    rc_store16((uint16)(t[0].s89ab, t[1].s89ab, t[2].s89ab, t[3].s89ab), 0, line + RC_TILE_COLUMNS * 8);
    rc_store16((uint16)(t[0].scdef, t[1].scdef, t[2].scdef, t[3].scdef), 0, line + RC_TILE_COLUMNS * 12);
  }
  for (uint p = 0; p < used; ++p) {
    for (uint row = 0; row < rows; ++row)
      for (uint i = 0; i < RC_NU; i += 16u)
        rc_store16(vload16(0, lines + row * (RC_TILE_COLUMNS * 4u) + p * RC_NU + i), 0, slots + p * RC_NPAD + row * RC_NU + i);
    for (uint k = rows * RC_NU; k < RC_NPAD; ++k) slots[p * RC_NPAD + k] = RC_NONE;
  }
  for (uint p = 0; p < used; ++p)
    for (uint word = 0; word < RC_NWORDS; ++word) rc_store16(vload16(p * RC_NWORDS + word, slots), word, out + p * stride);
}

#endif

/* frame: rays in the scene frame and the samples; the rest is set here. */
static inline void rc_primary_group(SceneArrays scene, GroupFrame frame, Closest* closest) {
  Cull world, cull;
  const RayGroup rays = frame.rays;
  frame.world = rays;
  frame.same = true;
  rc_frame_group(&frame, &world);
  const Projection world_map = frame.map;
  cull = world;
  Open open;
  open.count = 0;
  uint stack[RC_STACK];
  uint top = 1, base = 0, instance = RC_NONE;  /* entries from base upwards belong to the instance's tree */
  stack[0] = 0;
  while (top) {
    if (top == base) {
      if (open.count) rc_decide(scene, &frame, closest, instance, &open);
      instance = RC_NONE;
      base = 0;
      cull = world;
    }
    const uint entry = stack[--top], index = entry & ~RC_LEAF;
    if (!(entry & RC_LEAF)) {
      top = rc_push_children(&cull, 4, scene, index, instance != RC_NONE, stack, top);
    } else if (instance != RC_NONE) {
      rc_primary_block(scene, &frame, closest, &open, index, instance);
    } else {
      global const Instance* placed = rc_instance(scene, index);
      instance = index;
      frame.same = placed->flags & 1u;
      if (frame.same) {
        frame.rays = rays;
        frame.map = world_map;
      } else {
        const float4 r0 = frame.l0 = placed->local_from_world_0, r1 = frame.l1 = placed->local_from_world_1, r2 = frame.l2 = placed->local_from_world_2;
        frame.rays.origin = rc_map_point(r0, r1, r2, rays.origin);
        frame.rays.d0 = rc_map_vector(r0, r1, r2, rays.d0);
        frame.rays.du = rc_map_vector(r0, r1, r2, rays.du);
        frame.rays.dv = rc_map_vector(r0, r1, r2, rays.dv);
        rc_frame_group(&frame, &cull);
      }
      stack[top] = placed->root;
      base = top++;
    }
  }
  if (open.count) rc_decide(scene, &frame, closest, instance, &open);
}

#endif
