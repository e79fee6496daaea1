/* Reads: owners' records (kernels/lidar/layout.h), sub-rays, the scene, matter, air, pulse. Writes: rows of expected
 * photons of light scattered once and more, ledger, first hits. One work-item is one owner: a shot, or a pixel of a
 * shot; its rows are its own, so sums have one order whatever the launch. Next: lidar_air, then the host. */
#include "kernels/lidar/context.h"
#include "kernels/lidar/tables.h"
#include "kernels/lidar/first_hits.h"
#include "kernels/lidar/owner_rows.h"
#include "kernels/lidar/paths.h"

RC_BODY lidar_shots_body(uint owner, RC_PARAMETERS(RC_LIDAR_SHOTS_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  LidarTables tables = rc_tables(shots + (size_t)owner * RC_SHOT_FLOAT4S, RC_PASSED(RC_LIDAR_TABLE_ARGUMENTS));
  rc_read_plan(plan, &tables);
  tables.samples = samples, tables.exits = exits, tables.optics = optics, tables.lobes = lobes, tables.seed = seed;
  const LidarTables* t = &tables;
  const size_t own_floats = rc_floats_of_sum(t) * rc_own_floats(t);
#if RC_ROW_WINDOW
  RC_LINE float window[RC_ROW_WINDOW];
  const OwnerRows own = {window, window, stopped + (RC_HAS(t, STOPPED) ? owner * rc_stopped_floats(t) : 0)};
#else
  const OwnerRows own = {first + owner * own_floats, multiple + (RC_HAS(t, BOUNCES) ? owner * own_floats : 0),
                         stopped + (RC_HAS(t, STOPPED) ? owner * rc_stopped_floats(t) : 0)};
#endif
  LidarSums total;
  OwnerMemory memory;
  rc_begin_memory(t, &memory);
  rc_clear_sums(t, &total);
  rc_clear_rows(t, &own);

  for (uint begin = 0; begin < t->rays; begin += RC_CHUNK_SAMPLES) {
    global const Scatter* scatter = (global const Scatter*)samples + begin / RC_CHUNK_SAMPLES;
    const uint rays = min((uint)RC_CHUNK_SAMPLES, t->rays - begin);
    Closest closest;
    if (!RC_HAS(t, SINGLE)) rc_trace_bundle(scene, t, scatter, rays, &closest);
    for (uint slot = 0; slot < rays; slot += RC_WORD) {
      const HitWord word =
          RC_HAS(t, SINGLE) ? rc_trace_word(scene, t, begin + slot) : rc_word_of_bundle(scatter, &closest, slot);
      if (RC_HAS(t, HITS)) rc_write_hits(t, &word, owner, begin + slot, first_hits);
      rc_follow_word(scene, t, word.a, word.b, begin + slot, word.instances, word.primitives, own.first, own.multiple,
                     own.stopped, &memory, &total);
    }
  }

  rc_fold_memory(t, &memory, own.first, &total);
  rc_close_rows(t, &own, &total);
  for (uint line = 0; line < RC_LINES(t); ++line) {
    const size_t at = (size_t)owner * RC_LINES(t) + line;
    rc_write_sums(total.sum[line], sums + 2u * (at * RC_SUM_COUNT));
    for (uint i = 0; i < RC_LEDGER_COUNT; ++i) ledger[at * RC_LEDGER_COUNT + i] = total.ledger[line][i];
  }
#if RC_ROW_WINDOW
  rc_store_window(t, window, first + owner * own_floats);
#endif
  counts[owner] = t->rays + total.rays;
}

kernel void lidar_shots(RC_PARAMETERS(RC_LIDAR_SHOTS_ARGUMENTS)) {
  lidar_shots_body((uint)get_global_id(0), RC_PASSED(RC_LIDAR_SHOTS_ARGUMENTS));
}
