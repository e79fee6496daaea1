/* Where the light of 16 paths goes, for the ledger: integers in units of 2^-40 of what an owner emits, so that shares
 * add up exactly. */
#ifndef RAYCUBE_KERNELS_LIDAR_ENERGY_H
#define RAYCUBE_KERNELS_LIDAR_ENERGY_H

#include "kernels/lidar/connect.h"

static inline long16 rc_share16(long16 energy, float16 share) {
  return convert_long16(convert_float16(energy) * share);
}

/* A segment of the live paths that ends at `to` (relative to Q), with what air and volumes keep of its light. from_z:
 * height of its start. */
static inline void rc_pass_segment(const LidarTables* t, Paths16* paths, float16 from_z, Vector16 to, Vector16 unit,
                                   float16 length, LidarSums* sums) {
  if (!RC_MEDIA(t)) return;
  const int16 live = rc_bits16(paths->live);
  const long16 live_long = convert_long16(live);
  const Vector16 end = rc_plus16(rc_vector16(t->shot[RC_SHOT_REFERENCE]), to);
  float16 before[RC_MOST_LINE_NODES], of_volumes[RC_MOST_LINE_NODES];
  for (uint node = 0; node < RC_LINE_NODES(t); ++node) {
    before[node] = paths->depth[node];
    of_volumes[node] = 0.0f;
  }
  if (RC_HAS(t, AIR)) rc_air_depths(t, from_z, end.z, length, paths->depth);
  if (RC_HAS(t, VOLUMES)) {
    rc_volume_depths(t, end, unit, length, paths->live, of_volumes);
    for (uint node = 0; node < RC_LINE_NODES(t); ++node) paths->depth[node] += of_volumes[node];
  }
  for (uint line = 0; line < RC_LINES(t); ++line) {
    const float16 now = rc_line_transmission(t, line, paths->depth);
    const float16 share = select((float16)(1.0f), clamp(now / fmax(paths->passed[line], 1e-30f), 0.0f, 1.0f), live);
    const long16 left = rc_share16(paths->energy[line], share);
    const long16 lost = select((long16)(0), paths->energy[line] - left, live_long);
    if (RC_HAS(t, VOLUMES)) {
      /* Between air and volumes in the ratio of their depths, node by node. */
      float16 all = 1e-30f, volumes = 0.0f;
      for (uint node = t->first_node[line]; node < t->first_node[line + 1u]; ++node) {
        const float16 both = paths->depth[node] - before[node],
                      taken = t->node_weight[node] * exp(-before[node]) * -expm1(-both);
        all += taken;
        volumes +=
            taken * select((float16)(0.0f), clamp(of_volumes[node] / fmax(both, 1e-30f), 0.0f, 1.0f), both > 0.0f);
      }
      const long16 in_volumes = rc_share16(lost, clamp(volumes / all, 0.0f, 1.0f));
      sums->ledger[line][RC_LEDGER_VOLUMES] += rc_lane_sum_long(in_volumes);
      sums->ledger[line][RC_LEDGER_AIR] += rc_lane_sum_long(lost - in_volumes);
    } else {
      sums->ledger[line][RC_LEDGER_AIR] += rc_lane_sum_long(lost);
    }
    paths->energy[line] = select(paths->energy[line], left, live_long);
    paths->passed[line] = now;
  }
}

/* Energy that rays of a word from first_ray on start with, where lanes have none of their own (RC_LANE_ENERGY):
 * whatever starts ends at its first vertex. */
static inline long rc_emitted(const LidarTables* t, uint first_ray, uint lanes) {
  const uint rest = (uint)t->ledger_rest, more = min(rest - min(rest, first_ray), 16u);
  return (long)popcount(lanes) * t->ledger_unit + (long)popcount(lanes & ((1u << more) - 1u));
}

/* Takes what the lanes hold out of the paths and books it. */
static inline void rc_end_lanes(const LidarTables* t, Paths16* paths, uint lanes, LidarSums* sums, uint entry) {
  if (!lanes) return;
  if (!RC_LANE_ENERGY(t)) {
    const long held = rc_emitted(t, paths->first_ray, lanes);
    for (uint line = 0; line < RC_LINES(t); ++line) sums->ledger[line][entry] += held;
    paths->live &= ~lanes;
    return;
  }
  const long16 take = convert_long16(rc_bits16(lanes));
  for (uint line = 0; line < RC_LINES(t); ++line) {
    sums->ledger[line][entry] += rc_lane_sum_long(select((long16)(0), paths->energy[line], take));
    paths->energy[line] = select(paths->energy[line], (long16)(0), take);
  }
  paths->live &= ~lanes;
}

/* Splits the energy at the vertices: `kept` stays on its way into the next segment, the rest of `leaving` goes to an
 * entry, the remainder is absorbed. Shares of what arrives; even: `booked` is one number in all live lanes. */
static inline void rc_split_energy(const LidarTables* t, Paths16* paths, uint line, float16 kept, float16 booked,
                                   bool even, LidarSums* sums, uint entry) {
  if (!RC_LANE_ENERGY(t)) {
    const long arrives = rc_emitted(t, paths->first_ray, paths->live);
    const float share = even ? (float)popcount(paths->live) * booked.s0
                             : rc_lane_sum(select((float16)(0.0f), booked, rc_bits16(paths->live)));
    const long goes = min((long)((float)t->ledger_unit * share), arrives);
    sums->ledger[line][entry] += goes;
    sums->ledger[line][RC_LEDGER_ABSORBED] += arrives - goes;
    return;
  }
  const long16 live = convert_long16(rc_bits16(paths->live));
  const long16 arrives = select((long16)(0), paths->energy[line], live);
  const long16 stays = rc_share16(arrives, kept), goes = rc_share16(arrives, booked);
  sums->ledger[line][entry] += rc_lane_sum_long(goes);
  sums->ledger[line][RC_LEDGER_ABSORBED] += rc_lane_sum_long(arrives - stays - goes);
  paths->energy[line] = select(paths->energy[line], stays, live);
}

#endif
