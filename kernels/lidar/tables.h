/* What the kernels of shots and of the air's return read alike. */
#ifndef RAYCUBE_KERNELS_LIDAR_TABLES_H
#define RAYCUBE_KERNELS_LIDAR_TABLES_H

#include "kernels/lidar/arguments.h"
#include "kernels/lidar/context.h"

/* Counts of the launch. */
static inline void rc_read_plan(global const uint* plan, LidarTables* t) {
  t->features = plan[RC_PLAN_FEATURES];
  t->lines = plan[RC_PLAN_LINES];
  t->line_nodes = plan[RC_PLAN_NODES];
  t->columns = plan[RC_PLAN_COLUMNS];
  t->rows = plan[RC_PLAN_ROWS];
  t->rays = plan[RC_PLAN_RAYS];
  t->slots = plan[RC_PLAN_SLOTS];
  t->bounces = plan[RC_PLAN_BOUNCES];
  t->volume_count = plan[RC_PLAN_VOLUMES];
  t->padded_taps = (int)plan[RC_PLAN_TAPS];
  t->lobe_lines = plan[RC_PLAN_LOBE_LINES];
  t->lobe_stride = plan[RC_PLAN_LOBE_STRIDE];
  t->own_pixels = RC_HAS(t, PIXELS) ? t->columns * t->rows : 1u;
  t->row = rc_row_floats((uint)t->bins, (uint)t->padded_taps);
  t->ledger_unit = (1l << RC_LEDGER_BITS) / (long)t->rays;
  t->ledger_rest = (1l << RC_LEDGER_BITS) - t->ledger_unit * (long)t->rays;
}

/* An owner's tables from its kernel's arguments; what only one of the two kernels reads is 0. rc_read_plan goes on from
 * there: nothing is read here, since oclgrind has no word for what clang 14 makes of reads by restricted pointers of a
 * function that it inlines. */
static inline LidarTables rc_tables(global const float4* shot, RC_PARAMETERS(RC_LIDAR_TABLE_ARGUMENTS)) {
  LidarTables tables = {.shot = shot,
                        .photons = photons,
                        .node_weight = node_weight,
                        .first_node = first_node,
                        .air = (global const float2*)air,
                        .volumes = volumes,
                        .volume_values = volume_values,
                        .volume_depth = volume_depth,
                        .taps = taps,
                        .settings = settings,
                        .bins = bins,
                        .tap_count = taps_used,
                        .first_tap = first_tap,
                        .phases = phases,
                        .cells = cells};
  return tables;
}

#endif
