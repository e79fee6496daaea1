/* Reads: owners' records, tables of their beams (lidar_beam), air, volumes, shares of rays that surfaces stopped
 * (lidar_shots). Writes: rows of expected photons that air and particles send back once scattered, and their sums. One
 * work-item is one owner. Every bin is two cells of the whole way's length; a cell's light is taken at its Gauss point
 * on the middle ray, what particles scatter by their integral over the cell. Impulses of all bins come first, at two
 * phases, and are spread by the pulse's shares in one pass. Next: the host. */
#undef RC_ROW_WINDOW /* an option of lidar_shots: rows here are added up where they lie */
#include "kernels/lidar/context.h"
#include "kernels/lidar/tables.h"
#include "kernels/lidar/way_rows.h"

RC_BODY lidar_air_body(uint owner, RC_PARAMETERS(RC_LIDAR_AIR_ARGUMENTS)) {
  LidarTables all = rc_tables(shots + (size_t)owner * RC_SHOT_FLOAT4S, RC_PASSED(RC_LIDAR_TABLE_ARGUMENTS));
  rc_read_plan(plan, &all);
  const LidarTables* t = &all;
  const Beam beam = rc_beam(t);
  const size_t own_rows = (size_t)RC_OWN_PIXELS(t) * RC_LINES(t);
  global float* own = rows + (size_t)owner * rc_way_rows(t) * own_rows * t->row;
  const Impulses impulses = rc_impulses(t, scratch, owner);
  rc_phase_shares(t, impulses);
  float total[RC_MOST_LINES][RC_SUM_COUNT][2];
  for (uint line = 0; line < RC_LINES(t); ++line)
    for (uint i = 0; i < RC_SUM_COUNT; ++i) total[line][i][0] = total[line][i][1] = 0.0f;

  for (uint pixel = 0; pixel < RC_OWN_PIXELS(t); ++pixel) {
    global const float* table = tables + ((size_t)beam_of[owner] * RC_OWN_PIXELS(t) + pixel) * RC_BEAM_FLOATS;
    rc_clear_impulses(impulses);
    Stopped gone = rc_begin_stopped(t, stopped + owner * rc_stopped_floats(t), pixel);
    Swept swept[2]; /* the two cells of a bin are one behind the other: each chain sweeps all */
    for (uint g = 0; g < 2u; ++g) rc_begin_sweep(t, swept + g);
    for (int bin = -t->padded_taps; bin < t->bins + t->padded_taps; bin += 16) {
      float16 lit[RC_MOST_LINES];
      rc_still_lit(t, &gone, bin, lit);
      WayLight light;
      for (uint g = 0; g < 2u; ++g) rc_way_light(t, &beam, table, backscatter, lit, bin, g, swept + g, &light);
      for (uint line = 0; line < RC_LINES(t); ++line) {
        rc_put(t, impulses, 0u, line, total[line], bin, light.air[line]);
        if (RC_HAS(t, VOLUMES)) rc_put(t, impulses, 1u, line, total[line], bin, light.particles[line]);
      }
    }
    for (uint kind = 0; kind < rc_way_rows(t); ++kind)
      for (uint line = 0; line < RC_LINES(t); ++line)
        rc_spread(t, impulses, kind, line, own + (kind * own_rows + pixel * RC_LINES(t) + line) * t->row);
  }
  for (uint line = 0; line < RC_LINES(t); ++line) {
    for (uint kind = 0; kind < rc_way_rows(t); ++kind)
      for (uint pixel = 0; pixel < RC_OWN_PIXELS(t); ++pixel)
        rc_close_row(t, own + (kind * own_rows + pixel * RC_LINES(t) + line) * t->row, total[line]);
    rc_write_sums(total[line], sums + 2u * (((size_t)owner * RC_LINES(t) + line) * RC_SUM_COUNT));
  }
}

kernel void lidar_air(RC_PARAMETERS(RC_LIDAR_AIR_ARGUMENTS)) {
  lidar_air_body((uint)get_global_id(0), RC_PASSED(RC_LIDAR_AIR_ARGUMENTS));
}
