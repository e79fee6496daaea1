/* A block of 16 triangles against samples anywhere in the field (RC_SCATTER), by words of 16 samples with their bounds. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_PRIMARY_SCATTER_H
#define RAYCUBE_KERNELS_GEOMETRY_PRIMARY_SCATTER_H

#include "kernels/geometry/primary_frame.h"

#if RC_SCATTER
static inline float rc_lane_most(float16 v) {
  const float8 a = rc_max8(v.lo, v.hi);
  const float4 b = fmax(a.lo, a.hi);
  const float2 c = fmax(b.lo, b.hi);
  return fmax(c.x, c.y);
}

static inline void rc_keep_word(Closest* closest, uint slot, float16 near, uint16 primitive, int16 taken, uint instance) {
  rc_store16(near, 0, closest->near + slot);
  rc_store16(primitive, 0, closest->primitive + slot);
  rc_store16(select(vload16(0, closest->instance + slot), (uint16)(instance), taken), 0, closest->instance + slot);
}

static inline void rc_primary_block(SceneArrays scene, const GroupFrame* frame, Closest* closest, Open* open, uint index, uint instance) {
  global const TriBlock* block = rc_block(scene, index);
  const uint first = index * RC_BLOCK;
  const Setup s = rc_setup_block(&frame->map, block, true);
  const RC_SAMPLE_SPACE Scatter* samples = frame->samples;
  uint lanes = rc_mask16(s.usable & (s.lo_a <= RC_HALF_A) & (s.hi_a >= -RC_HALF_A) & (s.lo_b <= RC_HALF_B) & (s.hi_b >= -RC_HALF_B));
  const uint behind_bits = rc_mask16(s.behind) ? rc_behind(frame, block, s.behind) : 0u;
  if (!(lanes | behind_bits)) return;
  RC_LINE float slack[16];
  rc_store16(rc_near_slack(&s), 0, slack);
  LaneForms form;
  rc_store_forms(&s, &form);
  /* Words outside, triangles inside: what is closest in a word stays in registers. */
  const int16 some = rc_bits16(lanes);
  const float most_a = rc_lane_most(select((float16)(-INFINITY), s.hi_a, some)), least_a = -rc_lane_most(select((float16)(-INFINITY), -s.lo_a, some));
  const float most_b = rc_lane_most(select((float16)(-INFINITY), s.hi_b, some)), least_b = -rc_lane_most(select((float16)(-INFINITY), -s.lo_b, some));
  for (uint base = 0; lanes && base < RC_SAMPLE_WORDS; base += 16u) {
    uint words = rc_mask16((vload16(0, samples->lo_a + base) <= most_a) & (vload16(0, samples->hi_a + base) >= least_a) &
                           (vload16(0, samples->lo_b + base) <= most_b) & (vload16(0, samples->hi_b + base) >= least_b));
    for (; words; words &= words - 1u) {
      const uint word = base + rc_lowest(words), slot = word * 16u;
      uint touching = lanes & rc_mask16((s.lo_a <= samples->hi_a[word]) & (s.hi_a >= samples->lo_a[word]) & (s.lo_b <= samples->hi_b[word]) & (s.hi_b >= samples->lo_b[word]));
      if (!touching) continue;
      const float16 a = vload16(0, samples->a + slot), b = vload16(0, samples->b + slot);
      const int16 real = a < INFINITY;
      float16 before = vload16(0, closest->near + slot);
      uint16 primitive = vload16(0, closest->primitive + slot);
      int16 taken = 0;
      for (; touching; touching &= touching - 1u) {
        const uint lane = rc_lowest(touching);
        const float16 l1 = fma((float16)(form.l1a[lane]), a, fma((float16)(form.l1b[lane]), b, (float16)(form.l1c[lane])));
        const float16 l2 = fma((float16)(form.l2a[lane]), a, fma((float16)(form.l2b[lane]), b, (float16)(form.l2c[lane])));
        const float16 least = rc_min16(rc_min16(l1, l2), (1.0f - l1) - l2), band = form.band[lane];
        const float16 near = fma(l1, (float16)(form.q1[lane]), fma(l2, (float16)(form.q2[lane]), (float16)(form.q0[lane])));
        const int16 exists = real & (least >= -band), inside = exists & (least > band), nearer = inside & (near > before);
        const uint rest = rc_mask16(exists & (~inside | (near == before)) & (near + slack[lane] >= before));
        before = select(before, near, nearer);
        primitive = select(primitive, (uint16)(first + lane), nearer);
        taken |= nearer;
        if (!rest) continue;
        rc_keep_word(closest, slot, before, primitive, taken, instance);
        RC_LINE float near_of[16];
        rc_store16(near, 0, near_of);
        const uint tied = rc_mask16(inside);
        for (uint left = rest; left; left &= left - 1u) {
          const uint k = rc_lowest(left);
          if (tied >> k & 1u) rc_keep(closest, slot + k, near_of[k], instance, first + lane);
          else rc_leave_open(scene, frame, closest, instance, open, first + lane, slot + k);
        }
        before = vload16(0, closest->near + slot);
        primitive = vload16(0, closest->primitive + slot);
        taken = 0;
      }
      if (rc_mask16(taken)) rc_keep_word(closest, slot, before, primitive, taken, instance);
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

#endif
#endif
