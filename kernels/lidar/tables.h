/* What the kernels of shots and of the air's return read alike. */
#ifndef RAYCUBE_KERNELS_LIDAR_TABLES_H
#define RAYCUBE_KERNELS_LIDAR_TABLES_H

#include "kernels/lidar/arguments.h"
#include "kernels/lidar/context.h"

/* An owner's tables from its kernel's arguments; what only one of the two kernels reads is 0. */
static inline LidarTables rc_tables(global const float4* shot, RC_PARAMETERS(RC_LIDAR_TABLE_ARGUMENTS)) {
  const LidarTables tables = {.shot = shot,
                              .photons = photons,
                              .node_weight = node_weight,
                              .first_node = first_node,
                              .air = (global const float2*)air,
                              .volumes = volumes,
                              .volume_values = volume_values,
                              .volume_depth = volume_depth,
                              .taps = taps,
                              .settings = settings,
                              .row = rc_row_floats((uint)bins),
                              .bins = bins,
                              .tap_count = taps_used,
                              .first_tap = first_tap,
                              .phases = phases,
                              .cells = cells};
  return tables;
}

#endif
