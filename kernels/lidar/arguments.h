/* Arguments of a LIDAR's kernels (kernels/shared/arguments.h). Where numbers lie: layout.h, context.h. */
#ifndef RAYCUBE_KERNELS_LIDAR_ARGUMENTS_H
#define RAYCUBE_KERNELS_LIDAR_ARGUMENTS_H

#include "kernels/shared/arguments.h"

/* clang-format off */
/* What shots and the air's return read alike, gathered by tables.h. */
#define RC_LIDAR_TABLE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  READ(rc_float, photons) NEXT() \
  READ(rc_float, node_weight) NEXT() \
  READ(rc_uint, first_node) NEXT() \
  READ(rc_float, air) NEXT() \
  READ(LidarVolume, volumes) NEXT() \
  READ(rc_float, volume_values) NEXT() \
  READ(rc_float, volume_depth) NEXT() \
  READ(rc_float, taps) NEXT() \
  READ(rc_float, settings) NEXT() \
  READ(rc_uint, plan) NEXT()            /* [RC_PLAN_COUNT] */ \
  VALUE(rc_int, bins) NEXT() \
  VALUE(rc_int, taps_used) NEXT() \
  VALUE(rc_int, first_tap) NEXT() \
  VALUE(rc_int, phases) NEXT() \
  VALUE(rc_int, cells)                  /* of a bin, for moments; 0: none */

#define RC_LIDAR_SHOTS_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(rc_float4, shots) NEXT()         /* [owner][RC_SHOT_FLOAT4S] */ \
  READ(rc_float, samples) NEXT() \
  READ(rc_float, exits) NEXT() \
  READ(rc_float4, optics) NEXT() \
  READ(Lobe, lobes) NEXT() \
  RC_LIDAR_TABLE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  WRITE(rc_float, first) NEXT()         /* [owner][sum, rest][pixel][line][row], light scattered once */ \
  WRITE(rc_float, multiple) NEXT()      /* the same, scattered more often */ \
  WRITE(rc_float, stopped) NEXT()       /* [owner][rc_stopped_floats] */ \
  WRITE(rc_long, ledger) NEXT()         /* [owner][line][RC_LEDGER_COUNT] */ \
  WRITE(rc_float, sums) NEXT()          /* [owner][line][RC_SUM_COUNT][2] */ \
  WRITE(rc_uint, counts) NEXT()         /* [owner]: rays */ \
  WRITE(rc_uint, first_hits) NEXT()     /* [owner][ray, padded]: instance, primitive */ \
  VALUE(rc_uint, seed)

#define RC_LIDAR_BEAM_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  READ(rc_float4, beams) NEXT()         /* [beam][RC_SHOT_FLOAT4S] */ \
  READ(rc_float, samples) NEXT() \
  READ(rc_float, exits) NEXT() \
  READ(rc_float, settings) NEXT() \
  READ(rc_uint, plan) NEXT() \
  WRITE(rc_float, tables) NEXT()        /* [beam][pixel][RC_BEAM_FLOATS] */ \
  VALUE(rc_int, bins)

#define RC_LIDAR_AIR_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  READ(rc_float4, shots) NEXT() \
  READ(rc_uint, beam_of) NEXT()         /* [owner] */ \
  READ(rc_float, tables) NEXT() \
  READ(rc_float, backscatter) NEXT()    /* [line][post], 1 / (m sr) */ \
  RC_LIDAR_TABLE_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) NEXT() \
  READ(rc_float, stopped) NEXT() \
  WRITE(rc_float, rows) NEXT()          /* [owner][kind][pixel][line][row] */ \
  WRITE(rc_float, scratch) NEXT()       /* [owner]: its impulses, shares of the pulse */ \
  WRITE(rc_float, sums)               /* [owner][line][RC_SUM_COUNT][2] */
/* clang-format on */

#endif
