/* A block of 16 triangles against the plain sample grid: projected at once and dropped unless a sample lies in their
 * rectangle; small ones (at most 3 x 3 samples) are tested with their pairs of triangle and sample as lanes, large ones
 * with a tile of 4 x 4 samples as lanes. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_PRIMARY_GRID_H
#define RAYCUBE_KERNELS_GEOMETRY_PRIMARY_GRID_H

#include "kernels/geometry/primary_frame.h"

#if RC_GRID
/* Image-plane coordinates of a column and of a row of the whole pixel. */
static inline float16 rc_column_a(const GroupFrame* frame, float16 column) {
  return fma(column, (float16)(frame->column_step), (float16)(frame->column_first));
}
static inline float16 rc_row_b(const GroupFrame* frame, float16 row) {
  return fma(row, (float16)(frame->row_step), (float16)(frame->row_first));
}

/* The grid of a launch's samples over the group; pixels: of a group, `used` of which exist. */
static inline void rc_set_grid(GroupFrame* frame, Sampling sampling, uint pixels, uint used, uint first_sample,
                               uint sample_count) {
  const float nu = (float)sampling.nu, nv = (float)sampling.nv;
  frame->sampling = sampling;
  frame->first_row = first_sample / sampling.nu;
  frame->rows = sample_count / sampling.nu;
  frame->columns = used * sampling.nu;
  frame->tile_columns = (pixels * sampling.nu + 15u) / 16u * 4u;
  frame->grid_columns = (float)(pixels * sampling.nu);
  frame->column_step = 1.0f / nu;
  frame->column_first = 0.5f / nu - 0.5f * (float)pixels;
  frame->row_step = 1.0f / nv;
  frame->row_first = 0.5f / nv - 0.5f;
}
/* Slots of its tiles. */
static inline uint rc_grid_slots(const GroupFrame* frame) {
  return 16u * frame->tile_columns * ((frame->rows + 3u) / 4u);
}

/* What a block leaves for later. */
typedef struct Pending {
  Open open;
} Pending;

static inline void rc_begin_pending(Pending* pending) { pending->open.count = 0; }
/* Before another frame is taken, and at the end. */
static inline void rc_settle(SceneArrays scene, const GroupFrame* frame, Closest* closest, uint instance,
                             Pending* pending) {
  if (pending->open.count) rc_decide(scene, frame, closest, instance, &pending->open);
}

/* Triangles of a block on the sample grid. */
typedef struct GridBlock {
  Setup setup;
  float16 left, right, above, below; /* samples inside each one's rectangle: first and last column, and row */
  float16 slack;                     /* of its nearness */
  uint first, instance;              /* primitive of lane 0; the placed mesh's */
} GridBlock;

/* Rectangles of the block's triangles. Returns the lanes that hold a sample. The 1e-5 covers the rounding of these four
 * lines. */
static inline int16 rc_grid_block(const GroupFrame* frame, GridBlock* block) {
  const Setup* s = &block->setup;
  const float nu = (float)frame->sampling.nu, nv = (float)frame->sampling.nv;
  const float column_shift = 0.5f * frame->grid_columns - 0.5f;
  block->left = rc_max16(ceil(fma(s->lo_a, (float16)(nu), (float16)(column_shift - 1e-5f))), (float16)(0.0f));
  block->right = rc_min16(floor(fma(s->hi_a, (float16)(nu), (float16)(column_shift + 1e-5f))),
                          (float16)((float)frame->columns - 1.0f));
  const float row_shift = 0.5f * nv - 0.5f - (float)frame->first_row;
  block->above = rc_max16(ceil(fma(s->lo_b, (float16)(nv), (float16)(row_shift - 1e-5f))), (float16)(0.0f));
  block->below =
      rc_min16(floor(fma(s->hi_b, (float16)(nv), (float16)(row_shift + 1e-5f))), (float16)((float)(frame->rows - 1u)));
  return s->usable & (block->right - block->left >= 0.0f) & (block->below - block->above >= 0.0f);
}

/* Lanes `small` with every sample of their rectangles, side by side: lane, column << 4, row << 8. Returns how many. */
static inline uint rc_small_pairs(const GridBlock* block, int16 small, uint* pairs) {
  const float16 columns = block->right - block->left, rows = block->below - block->above;
  uint count = 0;
  const uint16 own = (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (uint r = 0; r < RC_SMALL; ++r) {
    const int16 in_row = small & (rows >= (float)r);
    for (uint c = 0; c < RC_SMALL; ++c) {
      const uint bits = rc_mask16(in_row & (columns >= (float)c));
      if (!bits) break;
      rc_pack16(as_float16(own | (r << 8 | c << 4)), bits, (float*)(pairs + count));
      count += popcount(bits);
    }
  }
  return count;
}

/* Small triangles: pairs of triangle and sample as lanes. */
static inline void rc_primary_small(SceneArrays scene, const GroupFrame* frame, Closest* closest, Open* open,
                                    const GridBlock* block, int16 small) {
  const Setup* s = &block->setup;
  const uint first = block->first, instance = block->instance;
  const uint16 own = (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  RC_LINE uint pairs[RC_SMALL * RC_SMALL * 16 + 16];
  const uint count = rc_small_pairs(block, small, pairs);
  for (uint done = 0; done < count; done += 16u) {
    const int16 real = as_int16(own) < (int)(count - done);
    const uint16 pair = select((uint16)(0u), rc_load16(0, pairs + done), as_uint16(real)), lane_of = pair & 15u;
    const float16 column_of = rc_permute16(block->left, lane_of) + convert_float16(pair >> 4 & 15u),
                  row_of = rc_permute16(block->above, lane_of) + convert_float16(pair >> 8);
    const float16 a = rc_column_a(frame, column_of), b = rc_row_b(frame, row_of + (float)frame->first_row);
    const float16 l1 =
        fma(rc_permute16(s->l1a, lane_of), a, fma(rc_permute16(s->l1b, lane_of), b, rc_permute16(s->l1c, lane_of)));
    const float16 l2 =
        fma(rc_permute16(s->l2a, lane_of), a, fma(rc_permute16(s->l2b, lane_of), b, rc_permute16(s->l2c, lane_of)));
    const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2), band = rc_permute16(s->band, lane_of);
    uint bits = rc_mask16(real & (least >= -band));
    if (!bits) continue;
    const uint undecided = rc_mask16(least <= band);
    const float16 here =
        fma(l1, rc_permute16(s->q1, lane_of), fma(l2, rc_permute16(s->q2, lane_of), rc_permute16(s->q0, lane_of)));
    const uint16 row_u = convert_uint16(row_of), column_u = convert_uint16(column_of);
    const uint16 slot_of = (row_u / 4u * frame->tile_columns + column_u / 4u) * 16u + (row_u % 4u * 4u + column_u % 4u);
    const float16 here_most = here + rc_permute16(block->slack, lane_of);
/* Without pairs that something nearer hides already: the loop below would drop them one by one. */
#ifdef RC_HAS_GATHER
    const float16 before = rc_gather16(closest->near, slot_of, bits);
    bits &= rc_mask16(select(here, here_most, least <= band) >= before);
    if (!bits) continue;
#endif
    RC_LINE float near[16], near_most[16];
    RC_LINE uint slots[16], samples[16], primitives[16];
    rc_store16(here, 0, near);
    rc_store16(here_most, 0, near_most);
    rc_store16(slot_of, 0, slots);
    rc_store16(row_u << 16 | column_u, 0, samples);
    rc_store16(lane_of + first, 0, primitives);
    for (; bits; bits &= bits - 1u) {
      const uint k = rc_lowest(bits), slot = slots[k];
      if (!(undecided >> k & 1u))
        rc_keep(scene, closest, slot, near[k], instance, primitives[k]);
      else if (near_most[k] >= closest->near[slot])
        rc_leave_open(scene, frame, closest, instance, open, primitives[k], samples[k]);
    }
  }
}

/* One triangle in one tile of 4 x 4 samples, of which least, uncertain and near are told. */
static inline void rc_primary_tile(SceneArrays scene, const GroupFrame* frame, Closest* closest, Open* open,
                                   uint primitive, uint instance, uint tile_row, uint tile_column, float16 least,
                                   float16 uncertain, float16 near, float slack) {
  const uint slot = (tile_row * frame->tile_columns + tile_column) * 16u;
  const float16 before = rc_load16(0, closest->near + slot);
  const int16 inside = least > uncertain, nearer = inside & (near > before);
  uint rest = rc_mask16((least >= -uncertain) & (~inside | (near == before)));
  rc_store16(select(before, near, nearer), 0, closest->near + slot);
  rc_store16(select(rc_load16(0, closest->instance + slot), (uint16)(instance), nearer), 0, closest->instance + slot);
  rc_store16(select(rc_load16(0, closest->primitive + slot), (uint16)(primitive), nearer), 0,
             closest->primitive + slot);
  if (rest) {
    rest &= rc_mask16(near + slack >= before);
    const uint tied = rc_mask16(inside);
    RC_LINE float near_of[16];
    rc_store16(near, 0, near_of);
    for (; rest; rest &= rest - 1u) {
      const uint k = rc_lowest(rest), row = tile_row * 4u + k / 4u, column = tile_column * 4u + k % 4u;
      if (row >= frame->rows || column >= frame->columns) continue;
      if (tied >> k & 1u)
        rc_keep(scene, closest, slot + k, near_of[k], instance, primitive);
      else
        rc_leave_open(scene, frame, closest, instance, open, primitive, row << 16 | column);
    }
  }
}

/* Large triangles: the tiles of each one's rectangle. */
static inline void rc_primary_large(SceneArrays scene, const GroupFrame* frame, Closest* closest, Open* open,
                                    const GridBlock* block, uint large_bits) {
  const uint first = block->first, instance = block->instance;
  RC_LINE float slack_of[16];
  RC_LINE uint left_of[16], above_of[16], right_of[16], below_of[16];
  LaneForms form;
  rc_store_forms(&block->setup, &form);
  rc_store16(block->slack, 0, slack_of);
  rc_store16(convert_uint16(block->left), 0, left_of);
  rc_store16(convert_uint16(block->above), 0, above_of);
  rc_store16(convert_uint16(block->right), 0, right_of);
  rc_store16(convert_uint16(block->below), 0, below_of);
  const float16 lane_column = (float16)(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
  const float16 lane_row = (float16)(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3) + (float)frame->first_row;
  while (large_bits) {
    const uint lane = rc_lowest(large_bits);
    large_bits &= large_bits - 1u;
    const uint first_column = left_of[lane] / 4u, last_column = right_of[lane] / 4u, last_row = below_of[lane] / 4u;
    const float16 uncertain = form.band[lane];
    for (uint tile_row = above_of[lane] / 4u; tile_row <= last_row; ++tile_row) {
      const float16 b = rc_row_b(frame, lane_row + (float)(4u * tile_row));
      float16 column_of = lane_column + (float)(4u * first_column);
      const float16 l1_row = fma((float16)(form.l1b[lane]), b, (float16)(form.l1c[lane])),
                    l2_row = fma((float16)(form.l2b[lane]), b, (float16)(form.l2c[lane]));
      for (uint tile_column = first_column; tile_column <= last_column; ++tile_column, column_of += 4.0f) {
        const float16 a = rc_column_a(frame, column_of);
        const float16 l1 = fma((float16)(form.l1a[lane]), a, l1_row), l2 = fma((float16)(form.l2a[lane]), a, l2_row);
        const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2);
        const float16 near =
            fma(l1, (float16)(form.q1[lane]), fma(l2, (float16)(form.q2[lane]), (float16)(form.q0[lane])));
        rc_primary_tile(scene, frame, closest, open, first + lane, instance, tile_row, tile_column, least, uncertain,
                        near, slack_of[lane]);
      }
    }
  }
}

static inline void rc_primary_block(SceneArrays scene, const GroupFrame* frame, Closest* closest, Pending* pending,
                                    uint index, uint instance) {
  Open* open = &pending->open;
  global const TriBlock* triangles = rc_block(scene, index);
  GridBlock block;
  block.first = index * RC_BLOCK;
  block.instance = instance;
  block.setup = rc_setup_block(&frame->map, triangles, true);
  const int16 seen = rc_grid_block(frame, &block);
  const uint seen_bits = rc_mask16(seen);
  const uint behind_bits = rc_mask16(block.setup.behind) ? rc_behind(frame, triangles, block.setup.behind) : 0u;
  if (!(seen_bits | behind_bits)) return;
  const int16 small =
      seen & (block.right - block.left < (float)RC_SMALL) & (block.below - block.above < (float)RC_SMALL);
  const uint small_bits = rc_mask16(small), large_bits = seen_bits & ~small_bits;
  block.slack = rc_near_slack(&frame->map, &block.setup);
  if (small_bits) rc_primary_small(scene, frame, closest, open, &block, small);
  if (large_bits) rc_primary_large(scene, frame, closest, open, &block, large_bits);
  for (uint lanes = behind_bits; lanes; lanes &= lanes - 1u) { /* crosses the sensor's plane: every sample alone */
    const uint lane = rc_lowest(lanes);
    for (uint row = 0; row < frame->rows; ++row)
      for (uint column = 0; column < frame->columns; ++column)
        rc_leave_open(scene, frame, closest, instance, open, block.first + lane, row << 16 | column);
  }
}

/* From the tiles of a group to the slots of its pixels, by way of whole rows; samples without a hit and empty slots
 * become RC_NONE. Each step reads what the one before has long written: a load that spans fresh stores waits for them.
 * near: slots of a pixel; stride: of its hits; used: pixels that exist. */
static inline void rc_write_pixels(const GroupFrame* frame, const float* nearness, const uint* tiles, uint near,
                                   uint used, global uint* out, size_t stride) {
  RC_LINE uint lines[RC_SLOTS + 16], slots[RC_GROUP_PIXELS * RC_NEAR_SAMPLES + 16];
  const uint of_row = frame->sampling.nu, rows = frame->rows, wide = frame->tile_columns;
  for (uint tile = 0; tile < rc_grid_slots(frame) / 16u; tile += 4u) {
    uint16 t[4];
#pragma unroll
    for (uint i = 0; i < 4u; ++i)
      t[i] = select(rc_load16(tile + i, tiles), (uint16)(RC_NONE), rc_load16(tile + i, nearness) == 0.0f);
    uint* line = lines + (tile / wide * (wide * 4u) + tile % wide) * 4u;
    rc_store16((uint16)(t[0].s0123, t[1].s0123, t[2].s0123, t[3].s0123), 0, line);
    rc_store16((uint16)(t[0].s4567, t[1].s4567, t[2].s4567, t[3].s4567), 0, line + wide * 4u);
    rc_store16((uint16)(t[0].s89ab, t[1].s89ab, t[2].s89ab, t[3].s89ab), 0, line + wide * 8u);
    rc_store16((uint16)(t[0].scdef, t[1].scdef, t[2].scdef, t[3].scdef), 0, line + wide * 12u);
  }
  for (uint p = 0; p < used; ++p) {
    for (uint row = 0; row < rows; ++row)
      for (uint i = 0; i < of_row; i += 16u)
        rc_store16(rc_load16(0, lines + row * (wide * 4u) + p * of_row + i), 0, slots + p * near + row * of_row + i);
    for (uint k = rows * of_row; k < near; ++k) slots[p * near + k] = RC_NONE;
  }
  for (uint p = 0; p < used; ++p)
    for (uint word = 0; word < near / 16u; ++word)
      rc_store16(rc_load16(p * (near / 16u) + word, slots), 0, out + p * stride + word * RC_HIT_WORD);
}

#endif
#endif
