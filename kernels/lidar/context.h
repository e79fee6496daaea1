/* Build options, tables and sums of a LIDAR owner; layout.h tells where numbers lie.
 *
 *   RC_RECEIVER      0: rays from the exit (sub-rays), 1: rays from the pupil (samples of a pixel)
 *   RC_LASER_LINES   lines;  RC_LINE_NODES: spectral nodes of all of them
 *   RC_COLUMNS, RC_ROWS   pixels of the array (transmitter: 1 x 1 has the circular stop)
 *   RC_TAPS_PADDED   taps of the pulse rounded up to 16 (gate and pulse else are arguments: another gate needs no other
 *                    program)
 *   RC_RAY_COUNT     rays of an owner;  RC_CHUNK_SAMPLES: of one bundle (trace_args.h)
 *   RC_BOUNCES       scatterings a path may have
 *   RC_AIR           1: there is air;  RC_AIR_RETURN 1: it sends light back;  RC_VOLUMES: number of gas and particle
 *                    volumes
 *   RC_SINGLE        1: single rays (narrow beams, exits of their own), 0: bundles
 *   RC_EXITS         1: every sub-ray leaves from a place of its own
 *   RC_SHADOWS       1: some shot's ends differ: connections of the first vertex are traced
 *   RC_PLATES, RC_LEAVES, RC_GLOSS   some material has such a thing
 *   RC_SHAPED        1: some material does not reflect by Lambert's law
 *   RC_OVERLAP       1: vignetting;  RC_GAUSSIAN: profile of the beam (receiver)
 *   RC_ROW_WINDOW    floats of private memory that hold an owner's rows until they are whole (one bounce); 0: rows are
 *                    added up where they lie
 *   RC_FOLDED        1: hits are kept as moments of their bins and spread by the pulse once an owner (moments.h)
 *   RC_STOPPED       1: shares of rays stopped, for lidar_air;  RC_HITS 1: first hits are written */
#ifndef RAYCUBE_KERNELS_LIDAR_CONTEXT_H
#define RAYCUBE_KERNELS_LIDAR_CONTEXT_H

/* A -D that is missing has these defaults: one sub-ray word of a plain shot. */
#define RC_GROUP_PIXELS 1 /* a bundle is the rays of one owner */
#ifndef RC_CHUNK_SAMPLES
#define RC_CHUNK_SAMPLES 256 /* sub-rays of a bundle */
#endif
#ifndef RC_SUPPORT
#define RC_SUPPORT 4.0f /* width of the square that they cover */
#endif
#define RC_SAMPLE_SPACE global /* all owners share theirs */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/lanes.h"
#include "kernels/geometry/scene_arrays.h"
#include "kernels/lidar/layout.h"
#include "kernels/shared/structs.h"

#ifndef RC_RECEIVER
#define RC_RECEIVER 0
#endif
#ifndef RC_SINGLE
#define RC_SINGLE 0
#endif
#ifndef RC_EXITS
#define RC_EXITS 0
#endif
#ifndef RC_SHADOWS
#define RC_SHADOWS 0
#endif
#ifndef RC_PLATES
#define RC_PLATES 0
#endif
#ifndef RC_LEAVES
#define RC_LEAVES 0
#endif
#ifndef RC_GLOSS
#define RC_GLOSS 0
#endif
#ifndef RC_SHAPED
#define RC_SHAPED 0
#endif
#ifndef RC_OVERLAP
#define RC_OVERLAP 1
#endif
#ifndef RC_GAUSSIAN
#define RC_GAUSSIAN 1
#endif
#ifndef RC_STOPPED
#define RC_STOPPED 0
#endif
#ifndef RC_FOLDED
#define RC_FOLDED 0
#endif
#ifndef RC_HITS
#define RC_HITS 0
#endif
#ifndef RC_LASER_LINES
#define RC_LASER_LINES 1
#define RC_LINE_NODES 1
#endif
#ifndef RC_COLUMNS
#define RC_COLUMNS 1
#define RC_ROWS 1
#endif
#ifndef RC_TAPS_PADDED
#define RC_TAPS_PADDED 16
#endif
#ifndef RC_RAY_COUNT
#define RC_RAY_COUNT 256
#endif
#ifndef RC_BOUNCES
#define RC_BOUNCES 1
#endif
#ifndef RC_AIR
#define RC_AIR 0
#endif
#ifndef RC_VOLUMES
#define RC_VOLUMES 0
#endif
#ifndef RC_AIR_RETURN
#define RC_AIR_RETURN RC_AIR
#endif
#ifndef RC_ROW_WINDOW
#define RC_ROW_WINDOW 0
#endif
/* Where rows are added up. */
#if RC_ROW_WINDOW
#define RC_ROW_SPACE private
#else
#define RC_ROW_SPACE global
#endif
#define RC_MEDIA (RC_AIR || RC_VOLUMES)

/* Pixels whose rows an owner writes. */
#define RC_OWN_PIXELS (RC_RECEIVER ? 1 : RC_COLUMNS * RC_ROWS)
/* A row is padding, bins, padding: pulses that hang over the gate's ends need no branch, and what they lose is counted
 * after. */
#define RC_ROW_PAD RC_TAPS_PADDED
static inline uint rc_row_floats(uint bins) { return 2u * RC_ROW_PAD + RC_PADDED(bins); }
/* Rays of an owner rounded up to whole words. */
#define RC_PADDED_RAYS RC_PADDED(RC_RAY_COUNT)
/* Rays start again after the first surface. */
#define RC_CONTINUES (RC_BOUNCES > 1 || RC_PLATES)
/* Energy of a ray in the ledger; the first RC_LEDGER_REST rays have one unit more. */
#define RC_LEDGER_UNIT ((1l << RC_LEDGER_BITS) / RC_RAY_COUNT)
#define RC_LEDGER_REST ((1l << RC_LEDGER_BITS) - RC_LEDGER_UNIT * RC_RAY_COUNT)
#define RC_LANE_ENERGY (RC_CONTINUES || RC_MEDIA)

typedef struct LidarTables {
  global const float4* shot;       /* the owner's record */
  global const float* samples;     /* [chunk] as struct Scatter */
  global const float* exits;       /* [2][rays, padded]: exit_a, exit_b */
  global const float4* optics;     /* [surface][line]: reflectance, diffuse transmittance, straight one, gloss */
  global const Lobe* lobes;        /* [surface][line, where those differ][RC_LOBE_STRIDE]; then tables */
  global const float* photons;     /* [line] */
  global const float* node_weight; /* [node] */
  global const uint* first_node;   /* [line + 1] */
  global const float2* air;        /* [node][post]: depth from post 0, extinction per m of the cell above the post */
  global const LidarVolume* volumes;
  global const float* volume_values; /* of grids */
  global const float* volume_depth;  /* [volume][node]: depth of 1 ppm m of its gas */
  global const float* taps;          /* [phase + 1][RC_TAPS_PADDED], then [cell][RC_MOMENTS][RC_TAPS_PADDED] */
  global const float* settings;
  uint seed, row;                         /* row: floats of a padded row */
  int bins, tap_count, first_tap, phases; /* gate and pulse, host/lidar/lidar_plan.h */
  int cells;                              /* host/lidar/pulse_moments.h */
} LidarTables;

/* Rays stopped, of an owner: rows [pixel][line], then how many rays each pixel has. */
static inline size_t rc_stopped_floats(uint row) {
  return (size_t)RC_OWN_PIXELS * RC_LASER_LINES * row + RC_PADDED(RC_OWN_PIXELS);
}
/* Whether they are kept for every pixel: where a ray stays in one, as pupil and exit are one point. */
static inline bool rc_stops_by_pixel(const LidarTables* t) {
  return (RC_OWN_PIXELS > 1) & (RC_EXITS == 0) & (t->shot[RC_SHOT_AXIS].w == 1.0f);
}

/* What one owner adds up beside its rows. */
typedef struct LidarSums {
  float sum[RC_LASER_LINES][RC_SUM_COUNT][2];
  long ledger[RC_LASER_LINES][RC_LEDGER_COUNT];
  uint rays;
} LidarSums;

/* Adds to a sum of two floats: Knuth's two-sum. */
static inline void rc_add_float(float* sum, float x) {
  const float s = sum[0] + x, part = s - sum[0];
  sum[1] += (sum[0] - (s - part)) + (x - part);
  sum[0] = s;
}

/* Sums of an owner's line, to where the host reads them. */
static inline void rc_write_sums(float sum[RC_SUM_COUNT][2], global float* to) {
  for (uint i = 0; i < RC_SUM_COUNT; ++i) {
    to[2u * i] = sum[i][0];
    to[2u * i + 1u] = sum[i][1];
  }
}

static inline long rc_lane_sum_long(long16 v) {
  const long8 a = v.lo + v.hi;
  const long4 b = a.lo + a.hi;
  const long2 c = b.lo + b.hi;
  return c.x + c.y;
}

#endif
