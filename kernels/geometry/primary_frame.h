/* A group of primary rays in the frame of one instance: its projection and culling planes, the closest hits so far, and
 * the samples that linear forms leave open, decided 16 at a time by the single-ray test. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_PRIMARY_FRAME_H
#define RAYCUBE_KERNELS_GEOMETRY_PRIMARY_FRAME_H

#include "kernels/geometry/bundle.h"
#include "kernels/geometry/samples.h"
#include "kernels/geometry/user_order.h"

#ifndef RC_GROUP_PIXELS
#define RC_GROUP_PIXELS RC_GROUP_WIDTH /* most pixels of a group */
#endif
#if RC_GRID
/* Sample grid of a group: the pixels of a line side by side, kept in tiles of 4 x 4 samples, four tiles at a time. */
#define RC_SMALL 3
/* Samples of whole tiles, at most: of one row of samples a pixel each tile has three empty ones. */
#define RC_SLOTS (4 * RC_GROUP_PIXELS * RC_NEAR_SAMPLES + 64)
#else
/* Samples anywhere in the field: pixel p's sample k has slot p * near + k; words of 16 carry their bounds. */
#define RC_SLOTS (RC_GROUP_PIXELS * RC_NEAR_SAMPLES)
#define RC_SAMPLE_WORDS (RC_SLOTS / 16) /* most of them */
#define RC_BOUND_SLOTS ((RC_SAMPLE_WORDS + 15) / 16 * 16)
typedef struct Scatter {
  float a[RC_SLOTS], b[RC_SLOTS]; /* INFINITY: no sample */
  float lo_a[RC_BOUND_SLOTS], hi_a[RC_BOUND_SLOTS], lo_b[RC_BOUND_SLOTS], hi_b[RC_BOUND_SLOTS];
} Scatter;
/* Where a kernel keeps its samples. */
#ifndef RC_SAMPLE_SPACE
#define RC_SAMPLE_SPACE private
#endif
#endif

typedef struct Closest {
  float near[RC_SLOTS];                         /* nearness of the closest hit; 0: none */
  uint instance[RC_SLOTS], primitive[RC_SLOTS]; /* set where there is a hit */
} RC_LINE Closest;

/* The group in the frame of one instance (or of the scene). */
typedef struct GroupFrame {
  RayGroup rays;     /* in this frame, for the projection */
  RayGroup world;    /* in the scene frame: a single ray is made there and then mapped, as rc_trace_ray does */
  float4 l0, l1, l2; /* local_from_world */
  bool same;         /* the frame is the scene's */
  Projection map;
  float half_a, half_b; /* half the field that the group's samples cover, pixels */
#if RC_GRID
  Sampling sampling;
  uint first_row, rows;                                 /* of the chunk */
  uint columns;                                         /* of the pixels that exist */
  uint tile_columns;                                    /* tiles side by side, of all pixels */
  float grid_columns;                                   /* samples side by side, of all pixels */
  float column_step, column_first, row_step, row_first; /* a = column_first + column * column_step, b likewise */
#else
  const RC_SAMPLE_SPACE Scatter* samples;
  uint words; /* of the samples */
#endif
} GroupFrame;

/* Samples that the linear forms leave open, each with a triangle of the frame's mesh: decided 16 at a time. */
typedef struct Open {
  uint primitive[16], sample[16]; /* sample: slot, or in the grid row * 65536 + column */
  uint count;
} Open;

static inline float4 rc_sum_products(float4 x, float4 y) { return fabs(x) * fabs(y); }
static inline float rc_sum3(float4 v) { return v.x + v.y + v.z; }

/* A sample's single ray in the frame: the very operations of rc_trace_instance. */
static inline float4 rc_frame_direction(const GroupFrame* frame, float a, float b) {
  const float4 direction = rc_group_direction(frame->world, a, b);
  return frame->same ? direction : rc_map_vector(frame->l0, frame->l1, frame->l2, direction);
}
static inline float4 rc_frame_offset(const GroupFrame* frame, float a, float b) {
  const float4 offset = rc_group_offset(frame->world, a, b);
  return frame->same ? offset : rc_map_vector(frame->l0, frame->l1, frame->l2, offset);
}

/* Largest components of the ways from the group's start to points in its field, over their z; far: the largest (z -
 * ahead) / z. */
static inline float4 rc_field(const GroupFrame* frame, float far) {
  return far * fabs(frame->world.d0) + frame->half_a * fabs(frame->world.du) + frame->half_b * fabs(frame->world.dv);
}

/* The most that the tree below a root reaches beyond the group's start, z - ahead, or beyond it all. */
static inline float rc_reach_beyond(const Projection* map, global const BvhNode* root) {
  const float8 x = (map->z.x > 0.0f ? vload8(0, root->hi_x) : vload8(0, root->lo_x)) - map->origin.x;
  const float8 y = (map->z.y > 0.0f ? vload8(0, root->hi_y) : vload8(0, root->lo_y)) - map->origin.y;
  const float8 z = (map->z.z > 0.0f ? vload8(0, root->hi_z) : vload8(0, root->lo_z)) - map->origin.z;
  const float8 beyond = fma((float8)(map->z.x), x, fma((float8)(map->z.y), y, map->z.z * z));
  RC_LINE float of[8];
  vstore8(beyond, 0, of);
  float most = 0.0f;
  for (uint i = 0; i < root->count; ++i) most = fmax(most, of[i]);
  return most * 1.001f;
}

/* Nearness orders hits and is linear over the image plane, as all of A + B / z are. From the sensor itself it is 1 / z.
 * Far ahead of it that would tell only depths apart that differ by some ulp of the whole way: there it is (limit - (z -
 * ahead)) / z, above 0 up to the limit, and tells depths apart by ulp of the limit. limit: beyond all of the scene. */
static inline void rc_set_nearness(Projection* map, float limit) {
  map->near_0 = map->ahead > 0.0f ? limit : 1.0f;
  map->near_1 = map->ahead > 0.0f ? -1.0f : 0.0f;
}
static inline float16 rc_nearness(const Projection* map, float16 beyond) {
  /* Of a triangle seen edge-on the single-ray test's distance is all rounding, and may lie past the limit: still a hit.
   * */
  return rc_max16(fma((float16)(map->near_1), beyond, (float16)(map->near_0)), (float16)(1e-6f * map->near_0)) /
         (beyond + map->ahead);
}

/* Dual basis of (du, dv, d0): p - sensor = z (d0 + a du + b dv), so p - origin = (z - ahead) d0 + z (a du + b dv).
 * Errors, in pixels, of a and b at points inside the group's field, for this map and for the single-ray test together,
 * relative to what is subtracted there: |p - origin| / z, of which d0 has the share `far`. Rows 3 ulp, sum of products
 * 3 ulp; there the direction 3, its shear 3, the moved vertex 1, and 3 in reserve: 16 ulp of the sum of absolute
 * products. In the frame of an instance the three basis vectors are mapped here and every direction there, 3 ulp each
 * of the absolute products with the matrix, as is their sum: 24 ulp. Offsets of single rays, 3 ulp, are part of |p -
 * origin|. z = ahead + its row rounds 4 ulp. The nearness is the scene frame's for all instances. */
static inline void rc_frame_group(SceneArrays scene, uint root, GroupFrame* frame, Cull* cull) {
  const float4 du = frame->rays.du, dv = frame->rays.dv, d0 = frame->rays.d0;
  const float4 a = rc_cross(dv, d0), b = rc_cross(d0, du), z = rc_cross(du, dv);
  const float scale = 1.0f / rc_dot3(d0, z);
  frame->map.origin = frame->rays.origin;
  frame->map.a = a * scale;
  frame->map.b = b * scale;
  frame->map.z = z * scale;
  frame->map.ahead = frame->world.d0.w;
  const float half_a = frame->half_a, half_b = frame->half_b;
  const float beyond = frame->map.ahead > 0.0f ? rc_reach_beyond(&frame->map, rc_node(scene, root)) : 1.0f,
              far = beyond / (beyond + frame->map.ahead);
  if (frame->same) rc_set_nearness(&frame->map, 1.01f * beyond + 1.0f);
  const float4 span = fabs(du) + fabs(dv);
  float4 field = rc_field(frame, far);
  if (!frame->same) field = rc_map_vector(fabs(frame->l0), fabs(frame->l1), fabs(frame->l2), field);
  const float size = fmax(rc_sum3(rc_sum_products(frame->map.a, field)), rc_sum3(rc_sum_products(frame->map.b, field)));
  const float depth = rc_sum3(rc_sum_products(frame->map.z, field));
  const float growth =
      fmax(rc_sum3(rc_sum_products(frame->map.a, span)), rc_sum3(rc_sum_products(frame->map.b, span))) + depth;
  frame->map.error = (frame->same ? 16.0f : 24.0f) * RC_ULP * (size + half_a * depth) +
                     (frame->map.ahead > 0.0f ? 4.0f * RC_ULP * half_a : 0.0f);
  if (frame->map.ahead > 0.0f) frame->map.near_slack = 64.0f * RC_ULP * (frame->map.near_0 / frame->map.ahead + depth);
  frame->map.error_growth = 32.0f * RC_ULP * growth;
  frame->map.error_square = 32.0f * RC_ULP * rc_sum3(rc_sum_products(frame->map.z, span));
  /* A thousandth of a pixel for the single-ray test, which lets in rays within 1.5 ulp of a long edge (box_ray.h). */
  const float edge_a = half_a + 2.0f * frame->map.error + 1e-3f, edge_b = half_b + 2.0f * frame->map.error + 1e-3f;
  cull->ox = frame->rays.origin.x;
  cull->oy = frame->rays.origin.y;
  cull->oz = frame->rays.origin.z;
  const float ahead = frame->map.ahead;
  rc_set_plane(cull, 0, edge_a * frame->map.z - frame->map.a, edge_a * ahead);
  rc_set_plane(cull, 1, edge_a * frame->map.z + frame->map.a, edge_a * ahead);
  rc_set_plane(cull, 2, edge_b * frame->map.z - frame->map.b, edge_b * ahead);
  rc_set_plane(cull, 3, edge_b * frame->map.z + frame->map.b, edge_b * ahead);
}

/* Keeps the larger nearness, which is above 0; of equal ones that which goes before by the user's order. */
static inline void rc_keep(SceneArrays scene, Closest* closest, uint slot, float near, uint instance, uint primitive) {
  const bool first = near == closest->near[slot] && near > 0.0f &&
                     rc_user_before(scene, instance, primitive, closest->instance[slot], closest->primitive[slot]);
  if (near > closest->near[slot] || first) {
    closest->near[slot] = near;
    closest->instance[slot] = instance;
    closest->primitive[slot] = primitive;
  }
}

/* Of the lanes that have no linear form, those that the group can see: not all behind, not all beyond one side. */
static inline uint rc_behind(const GroupFrame* frame, global const TriBlock* block, int16 lanes) {
  global const float* at = (global const float*)block;
  const float edge_a = frame->half_a + 2.0f * frame->map.error, edge_b = frame->half_b + 2.0f * frame->map.error;
  int16 back = -1, left = -1, right = -1, above = -1, below = -1;
  for (int i = 0; i < 3; ++i) {
    const float16 x = rc_load16(0, at + 48 * i) - frame->map.origin.x,
                  y = rc_load16(0, at + 48 * i + 16) - frame->map.origin.y;
    const float16 z = rc_load16(0, at + 48 * i + 32) - frame->map.origin.z;
    const float16 a = rc_project_row(frame->map.a, x, y, z), b = rc_project_row(frame->map.b, x, y, z),
                  depth = rc_project_row(frame->map.z, x, y, z) + frame->map.ahead;
    const float16 slack = (fabs(a) + fabs(b) + fabs(depth)) * (frame->map.error + frame->map.error_growth);
    back &= depth <= 0.0f;
    left &= fma((float16)(edge_a), depth, a) < -slack;
    right &= fma((float16)(edge_a), depth, -a) < -slack;
    above &= fma((float16)(edge_b), depth, b) < -slack;
    below &= fma((float16)(edge_b), depth, -b) < -slack;
  }
  return rc_mask16(lanes & ~(back | left | right | above | below));
}

#if !RC_GRID
static inline uint rc_open_slot(const GroupFrame* frame, uint sample) { return sample; }
static inline void rc_open_position(const GroupFrame* frame, uint sample, float* a, float* b) {
  *a = frame->samples->a[sample];
  *b = frame->samples->b[sample];
}
#else
/* Slot of a sample of the chunk. */
static inline uint rc_open_slot(const GroupFrame* frame, uint sample) {
  const uint row = sample >> 16, column = sample & 0xffffu;
  return (row / 4u * frame->tile_columns + column / 4u) * 16u + row % 4u * 4u + column % 4u;
}
static inline void rc_open_position(const GroupFrame* frame, uint sample, float* a, float* b) {
  const uint row = sample >> 16, column = sample & 0xffffu, of_row = frame->sampling.nu, p = column / of_row;
  rc_group_sample(frame->sampling, 0u, 0u, p, (frame->first_row + row) * of_row + column - p * of_row, a, b);
}
#endif

/* Decides the open samples by the single-ray test and empties the list. */
__attribute__((noinline)) static void rc_decide(SceneArrays scene, const GroupFrame* frame, Closest* closest,
                                                uint instance, Open* open) {
  RC_LINE float corner[9][16], offset[3][16], direction[3][16];
  for (uint k = 0; k < open->count; ++k) {
    global const float* at =
        (global const float*)rc_block(scene, open->primitive[k] / RC_BLOCK) + open->primitive[k] % RC_BLOCK;
#pragma unroll
    for (uint i = 0; i < 9u; ++i) corner[i][k] = at[16u * i];
    float a, b;
    rc_open_position(frame, open->sample[k], &a, &b);
    const float4 d = rc_frame_direction(frame, a, b), o = rc_frame_offset(frame, a, b);
    direction[0][k] = d.x;
    direction[1][k] = d.y;
    direction[2][k] = d.z;
    offset[0][k] = o.x;
    offset[1][k] = o.y;
    offset[2][k] = o.z;
  }
  /* Each ray's own axes, as rc_make_ray takes them. Lanes without a pair get numbers: what lies there may be subnormal,
   * which is slow. */
  const int16 real = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) < (int)open->count;
  const float16 dx = select((float16)(1.0f), rc_load16(0, direction[0]), real),
                dy = select((float16)(1.0f), rc_load16(0, direction[1]), real);
  const float16 dz = select((float16)(1.0f), rc_load16(0, direction[2]), real);
  const int16 z_first = (fabs(dz) >= fabs(dx)) & (fabs(dz) >= fabs(dy)), y_first = fabs(dy) >= fabs(dx);
  const float16 none = 0.0f;
  float16 v[6][3]; /* corners, offset, origin, direction */
#pragma unroll
  for (uint i = 0; i < 6u; ++i) {
    const float4 o = frame->rays.origin;
    const float16 x = i < 4u ? select(none, i < 3u ? rc_load16(0, corner[3u * i % 9u]) : rc_load16(0, offset[0]), real)
                      : i == 4u ? (float16)(o.x)
                                : dx;
    const float16 y =
        i < 4u    ? select(none, i < 3u ? rc_load16(0, corner[(3u * i + 1u) % 9u]) : rc_load16(0, offset[1]), real)
        : i == 4u ? (float16)(o.y)
                  : dy;
    const float16 z =
        i < 4u    ? select(none, i < 3u ? rc_load16(0, corner[(3u * i + 2u) % 9u]) : rc_load16(0, offset[2]), real)
        : i == 4u ? (float16)(o.z)
                  : dz;
    v[i][0] = select(select(y, z, y_first), x, z_first);
    v[i][1] = select(select(z, x, y_first), y, z_first);
    v[i][2] = select(select(x, y, y_first), z, z_first);
  }
  float16 t;
  uint hits = rc_hit_pairs(v[0], v[1], v[2], v[4], v[3], v[5][0] / v[5][2], v[5][1] / v[5][2], 1.0f / v[5][2], &t) &
              ((1u << open->count) - 1u);
  open->count = 0;
  if (!hits) return;
  RC_LINE float near[16];
  rc_store16(rc_nearness(&frame->map, t), 0, near);
  for (; hits; hits &= hits - 1u) {
    const uint k = rc_lowest(hits);
    rc_keep(scene, closest, rc_open_slot(frame, open->sample[k]), near[k], instance, open->primitive[k]);
  }
}

static inline void rc_leave_open(SceneArrays scene, const GroupFrame* frame, Closest* closest, uint instance,
                                 Open* open, uint primitive, uint sample) {
  open->primitive[open->count] = primitive;
  open->sample[open->count] = sample;
  if (++open->count == 16u) rc_decide(scene, frame, closest, instance, open);
}

/* How far above its linear form a triangle's nearness may lie by the single-ray test, on samples that may belong to it:
 * what the form moves in the band outside, and 64 roundings of the farthest corner's distance, or of what the start
 * ahead leaves of it. An open sample whose nearness stays below what is kept already needs no decision. */
static inline float16 rc_near_slack(const Projection* map, const Setup* s) {
  const float16 q1 = s->q0 + s->q1, q2 = s->q0 + s->q2;
  const float16 most = rc_max16(s->q0, rc_max16(q1, q2)), least = rc_min16(s->q0, rc_min16(q1, q2));
  const float16 rounded = map->ahead > 0.0f ? (float16)(map->near_slack) : 64.0f * RC_ULP * most * (most / least);
  return fma(2.0f * s->band, fabs(s->q1) + fabs(s->q2), rounded);
}

#endif
