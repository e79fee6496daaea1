/* A block of 16 triangles against samples anywhere in the field, by words of 16 samples with their bounds.
 * */
#ifndef RAYCUBE_KERNELS_GEOMETRY_PRIMARY_SCATTER_H
#define RAYCUBE_KERNELS_GEOMETRY_PRIMARY_SCATTER_H

#include "kernels/geometry/primary_frame.h"

#if !RC_GRID
static inline void rc_keep_word(Closest* closest, uint slot, float16 near, uint16 primitive, int16 taken,
                                uint instance) {
  rc_store16(near, 0, closest->near + slot);
  rc_store16(primitive, 0, closest->primitive + slot);
  rc_store16(select(rc_load16(0, closest->instance + slot), (uint16)(instance), taken), 0, closest->instance + slot);
}

/* Triangles whose rectangles lie in the field, of several blocks of one frame, side by side: tested against the words
 * of samples when there are enough of them, so that what is closest in a word stays in registers. */
#define RC_CANDIDATES 64
typedef struct Candidates {
  float l1a[RC_CANDIDATES + 16], l1b[RC_CANDIDATES + 16], l1c[RC_CANDIDATES + 16], l2a[RC_CANDIDATES + 16],
      l2b[RC_CANDIDATES + 16], l2c[RC_CANDIDATES + 16];
  float q0[RC_CANDIDATES + 16], q1[RC_CANDIDATES + 16], q2[RC_CANDIDATES + 16], band[RC_CANDIDATES + 16],
      slack[RC_CANDIDATES + 16];
  float lo_a[RC_CANDIDATES + 16], hi_a[RC_CANDIDATES + 16], lo_b[RC_CANDIDATES + 16], hi_b[RC_CANDIDATES + 16];
  uint primitive[RC_CANDIDATES + 16];
} RC_LINE Candidates;

/* What blocks leave for later. */
typedef struct Pending {
  Candidates candidates;
  uint count; /* of candidates */
  Open open;
} Pending;

static inline void rc_begin_pending(Pending* pending) { pending->count = pending->open.count = 0; }

/* Which of 16 candidates may hold a sample of a word: rectangles that meet, and the word's not wholly beyond an edge
 * and its band. Forms grow along a and b evenly, rounding too, so each is largest at the corner its slopes point to;
 * the third takes another order of rounding, which the second band holds. */
static inline uint rc_candidates_touch(const Candidates* c, uint first, float lo_a, float hi_a, float lo_b,
                                       float hi_b) {
  const float16 l1a = rc_load16(0, c->l1a + first), l1b = rc_load16(0, c->l1b + first),
                l1c = rc_load16(0, c->l1c + first);
  const float16 l2a = rc_load16(0, c->l2a + first), l2b = rc_load16(0, c->l2b + first),
                l2c = rc_load16(0, c->l2c + first);
  const float16 a0 = lo_a, a1 = hi_a, b0 = lo_b, b1 = hi_b, band = rc_load16(0, c->band + first);
  const float16 l0a = -l1a - l2a, l0b = -l1b - l2b, l0c = (1.0f - l1c) - l2c;
  const float16 l1 = fma(l1a, l1a > 0.0f ? a1 : a0, fma(l1b, l1b > 0.0f ? b1 : b0, l1c));
  const float16 l2 = fma(l2a, l2a > 0.0f ? a1 : a0, fma(l2b, l2b > 0.0f ? b1 : b0, l2c));
  const float16 l0 = fma(l0a, l0a > 0.0f ? a1 : a0, fma(l0b, l0b > 0.0f ? b1 : b0, l0c));
  return rc_mask16((rc_load16(0, c->lo_a + first) <= hi_a) & (rc_load16(0, c->hi_a + first) >= lo_a) &
                   (rc_load16(0, c->lo_b + first) <= hi_b) & (rc_load16(0, c->hi_b + first) >= lo_b) &
                   (rc_min16(l1, l2) >= -band) & (l0 >= -2.0f * band));
}

/* Tests the candidates against all words and empties the list. */
__attribute__((noinline)) static void rc_test_candidates(SceneArrays scene, const GroupFrame* frame, Closest* closest,
                                                         uint instance, Pending* pending) {
  const Candidates* c = &pending->candidates;
  const RC_SAMPLE_SPACE Scatter* samples = frame->samples;
  const uint count = pending->count;
  pending->count = 0;
  for (uint word = 0; word < frame->words; ++word) {
    const uint slot = word * 16u;
    ulong touching = 0;
    for (uint first = 0; first < count; first += 16u)
      touching |= (ulong)rc_candidates_touch(c, first, samples->lo_a[word], samples->hi_a[word], samples->lo_b[word],
                                             samples->hi_b[word])
                  << first;
    touching &= ~0ul >> (64u - count);
    if (!touching) continue;
    const float16 a = rc_load16(0, samples->a + slot), b = rc_load16(0, samples->b + slot);
    const int16 real = a < INFINITY;
    float16 before = rc_load16(0, closest->near + slot);
    uint16 primitive = rc_load16(0, closest->primitive + slot);
    int16 taken = 0;
    for (; touching; touching &= touching - 1u) {
      const uint k = 63u - (uint)clz(touching & (0ul - touching));
      const float16 l1 = fma((float16)(c->l1a[k]), a, fma((float16)(c->l1b[k]), b, (float16)(c->l1c[k])));
      const float16 l2 = fma((float16)(c->l2a[k]), a, fma((float16)(c->l2b[k]), b, (float16)(c->l2c[k])));
      const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2), band = c->band[k];
      const float16 near = fma(l1, (float16)(c->q1[k]), fma(l2, (float16)(c->q2[k]), (float16)(c->q0[k])));
      const int16 exists = real & (least >= -band), inside = exists & (least > band), nearer = inside & (near > before);
      const uint rest = rc_mask16(exists & (~inside | (near == before)) & (near + c->slack[k] >= before));
      before = select(before, near, nearer);
      primitive = select(primitive, (uint16)(c->primitive[k]), nearer);
      taken |= nearer;
      if (!rest) continue;
      rc_keep_word(closest, slot, before, primitive, taken, instance);
      RC_LINE float near_of[16];
      rc_store16(near, 0, near_of);
      const uint tied = rc_mask16(inside);
      for (uint left = rest; left; left &= left - 1u) {
        const uint lane = rc_lowest(left);
        if (tied >> lane & 1u)
          rc_keep(scene, closest, slot + lane, near_of[lane], instance, c->primitive[k]);
        else
          rc_leave_open(scene, frame, closest, instance, &pending->open, c->primitive[k], slot + lane);
      }
      before = rc_load16(0, closest->near + slot);
      primitive = rc_load16(0, closest->primitive + slot);
      taken = 0;
    }
    if (rc_mask16(taken)) rc_keep_word(closest, slot, before, primitive, taken, instance);
  }
}

/* Before another frame is taken, and at the end. */
static inline void rc_settle(SceneArrays scene, const GroupFrame* frame, Closest* closest, uint instance,
                             Pending* pending) {
  if (pending->count) rc_test_candidates(scene, frame, closest, instance, pending);
  if (pending->open.count) rc_decide(scene, frame, closest, instance, &pending->open);
}

static inline void rc_primary_block(SceneArrays scene, const GroupFrame* frame, Closest* closest, Pending* pending,
                                    uint index, uint instance) {
  global const TriBlock* block = rc_block(scene, index);
  const uint first = index * RC_BLOCK;
  const Setup s = rc_setup_block(&frame->map, block, true);
  const uint lanes = rc_mask16(s.usable & (s.lo_a <= frame->half_a) & (s.hi_a >= -frame->half_a) &
                               (s.lo_b <= frame->half_b) & (s.hi_b >= -frame->half_b));
  const uint behind_bits = rc_mask16(s.behind) ? rc_behind(frame, block, s.behind) : 0u;
  if (lanes) {
    if (pending->count + popcount(lanes) > RC_CANDIDATES) rc_test_candidates(scene, frame, closest, instance, pending);
    Candidates* c = &pending->candidates;
    const uint at = pending->count;
    pending->count += popcount(lanes);
    rc_pack16(s.l1a, lanes, c->l1a + at);
    rc_pack16(s.l1b, lanes, c->l1b + at);
    rc_pack16(s.l1c, lanes, c->l1c + at);
    rc_pack16(s.l2a, lanes, c->l2a + at);
    rc_pack16(s.l2b, lanes, c->l2b + at);
    rc_pack16(s.l2c, lanes, c->l2c + at);
    rc_pack16(s.q0, lanes, c->q0 + at);
    rc_pack16(s.q1, lanes, c->q1 + at);
    rc_pack16(s.q2, lanes, c->q2 + at);
    rc_pack16(s.band, lanes, c->band + at);
    rc_pack16(rc_near_slack(&frame->map, &s), lanes, c->slack + at);
    rc_pack16(s.lo_a, lanes, c->lo_a + at);
    rc_pack16(s.hi_a, lanes, c->hi_a + at);
    rc_pack16(s.lo_b, lanes, c->lo_b + at);
    rc_pack16(s.hi_b, lanes, c->hi_b + at);
    rc_pack16(as_float16((uint16)(first) + (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)), lanes,
              (float*)(c->primitive + at));
  }
  for (uint rest = behind_bits; rest; rest &= rest - 1u) /* crosses the sensor's plane: every sample alone */
    for (uint slot = 0; slot < 16u * frame->words; ++slot)
      if (frame->samples->a[slot] < INFINITY)
        rc_leave_open(scene, frame, closest, instance, &pending->open, first + rc_lowest(rest), slot);
}

/* Positions of samples first .. first + count - 1 of the group's pixels, `near` slots each, and the bounds of their
 * words. */
static inline void rc_scatter_samples(Scatter* samples, Sampling sampling, uint near, uint seed, GroupPlace place,
                                      uint first, uint count) {
  for (uint p = 0; p < place.used; ++p)
    for (uint k = 0; k < near; k += 16u) {
      float a[16], b[16];
      rc_group_samples(sampling, seed, place.number + p, p, first + k, a, b);
      for (uint i = 0; i < 16u; ++i) {
        const bool exists = k + i < count;
        samples->a[p * near + k + i] = exists ? a[i] : INFINITY;
        samples->b[p * near + k + i] = exists ? b[i] : INFINITY;
      }
    }
  for (uint word = 0; word < place.used * near / 16u; ++word) {
    float lo_a = INFINITY, hi_a = -INFINITY, lo_b = INFINITY, hi_b = -INFINITY;
    for (uint k = 0; k < 16u; ++k) {
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

#endif
#endif
