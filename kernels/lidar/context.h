/* Build options, tables and sums of a LIDAR owner; layout.h tells where numbers lie. Counts and what a launch has are
 * arguments (layout.h), so that launches share programs. Options are:
 *
 *   RC_FEATURES      what the program can do, of RC_FEATURE_* (layout.h)
 *   RC_MOST_LINES    lines that private arrays have room for, and spectral nodes of all of them (RC_MOST_LINE_NODES);
 *                    1: one line of one node
 *   RC_CHUNK_SAMPLES slots of a bundle of rays (trace_args.h)
 *   RC_ROW_WINDOW    floats of private memory that hold an owner's rows until they are whole (one bounce); 0: rows are
 *                    added up where they lie */
#ifndef RAYCUBE_KERNELS_LIDAR_CONTEXT_H
#define RAYCUBE_KERNELS_LIDAR_CONTEXT_H

/* A -D that is missing has these defaults: one sub-ray word of a plain shot. */
#define RC_GROUP_PIXELS 1 /* a bundle is the rays of one owner */
#ifndef RC_CHUNK_SAMPLES
#define RC_CHUNK_SAMPLES 256 /* sub-rays of a bundle */
#endif
#define RC_SAMPLE_SPACE global /* all owners share theirs */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/lanes.h"
#include "kernels/geometry/scene_arrays.h"
#include "kernels/lidar/layout.h"
#include "kernels/shared/structs.h"

#ifndef RC_FEATURES
#define RC_FEATURES (RC_FEATURE_OVERLAP | RC_FEATURE_GAUSSIAN)
#endif
#ifndef RC_MOST_LINES
#define RC_MOST_LINES 1
#endif
#define RC_MOST_LINE_NODES (RC_NODES_OF_ROOM(RC_MOST_LINES))
#ifndef RC_ROW_WINDOW
#define RC_ROW_WINDOW 0
#endif
/* Where rows are added up. */
#if RC_ROW_WINDOW
#define RC_ROW_SPACE private
#else
#define RC_ROW_SPACE global
#endif

#ifdef __clang__
/* Clang takes an operand of && that is a constant for a slip. */
#pragma clang diagnostic ignored "-Wconstant-logical-operand"
#endif
/* Whether the program can have a feature, and whether the launch has it. What it cannot have is left out of it: the
 * first operand is a constant. */
#define RC_CAN(feature) ((RC_FEATURES & RC_FEATURE_##feature) != 0u)
#define RC_HAS(t, feature) (RC_CAN(feature) && ((t)->features & RC_FEATURE_##feature))
#define RC_LINES(t) (RC_MOST_LINES == 1 ? 1u : (t)->lines)
#define RC_LOBE_LINES(t) (RC_MOST_LINES == 1 ? 1u : (t)->lobe_lines)
#define RC_LINE_NODES(t) (RC_MOST_LINES == 1 ? 1u : (t)->line_nodes)
/* Pixels whose rows an owner writes. */
#define RC_OWN_PIXELS(t) (RC_CAN(PIXELS) ? (t)->own_pixels : 1u)
#define RC_MEDIA(t) (RC_HAS(t, AIR) || RC_HAS(t, VOLUMES))
/* Rays start again after the first surface. */
#define RC_CONTINUES(t) (RC_HAS(t, BOUNCES) || RC_HAS(t, PLATES))
/* Vertices have points off their surface, from which rays start. */
#define RC_POINTS_OFF(t) (RC_CONTINUES(t) || RC_HAS(t, SHADOWS))
/* Lanes have energies of their own in the ledger. */
#define RC_LANE_ENERGY(t) (RC_CONTINUES(t) || RC_MEDIA(t))

typedef struct LidarTables {
  global const float4* shot;       /* the owner's record */
  global const float* samples;     /* [chunk] as struct Scatter */
  global const float* exits;       /* [2][rays, padded]: exit_a, exit_b */
  global const float4* optics;     /* [surface][line]: reflectance, diffuse transmittance, straight one, gloss */
  global const Lobe* lobes;        /* [surface][line, where those differ][lobe_stride]; then tables */
  global const float* photons;     /* [line] */
  global const float* node_weight; /* [node] */
  global const uint* first_node;   /* [line + 1] */
  global const float2* air;        /* [node][post]: depth from post 0, extinction per m of the cell above the post */
  global const LidarVolume* volumes;
  global const float* volume_values; /* of grids */
  global const float* volume_depth;  /* [volume][node]: depth of 1 ppm m of its gas */
  global const float* taps;          /* [phase + 1][tap, padded], then [cell][RC_MOMENTS][tap, padded] */
  global const float* settings;
  /* RC_PLAN_* */
  uint features, lines, line_nodes, columns, rows, rays, slots, bounces, volume_count, lobe_lines, lobe_stride;
  int padded_taps;
  uint own_pixels;
  uint seed, row;                         /* row: floats of a padded row */
  int bins, tap_count, first_tap, phases; /* gate and pulse, host/lidar/lidar_plan.h */
  int cells;                              /* host/lidar/pulse_moments.h */
  long ledger_unit, ledger_rest;          /* energy of a ray; the first rays, so many, have one unit more */
} LidarTables;

/* A row is padding, bins, padding, each padding as long as the padded taps: pulses that hang over the gate's ends need
 * no branch, and what they lose is counted after. */
static inline uint rc_row_floats(uint bins, uint padded_taps) { return 2u * padded_taps + RC_PADDED(bins); }
static inline uint rc_padded_rays(const LidarTables* t) { return RC_PADDED(t->rays); }

/* Of all rows of an owner, of one order of scattering: [pixel][line][row]. */
static inline size_t rc_own_floats(const LidarTables* t) { return (size_t)RC_OWN_PIXELS(t) * RC_LINES(t) * t->row; }
/* What an owner's bins are sums of: their rests lie behind all of its rows. */
static inline size_t rc_floats_of_sum(const LidarTables* t) { return RC_HAS(t, RESTS) ? 2u : 1u; }

/* Rays stopped, of an owner: rows [pixel][line], then how many rays each pixel has. */
static inline size_t rc_stopped_floats(const LidarTables* t) {
  return rc_own_floats(t) + RC_PADDED(RC_OWN_PIXELS(t));
}
/* Whether they are kept for every pixel: where a ray stays in one, as pupil and exit are one point. */
static inline bool rc_stops_by_pixel(const LidarTables* t) {
  return RC_OWN_PIXELS(t) > 1u && !RC_HAS(t, EXITS) && t->shot[RC_SHOT_AXIS].w == 1.0f;
}

/* What one owner adds up beside its rows. */
typedef struct LidarSums {
  float sum[RC_MOST_LINES][RC_SUM_COUNT][2];
  long ledger[RC_MOST_LINES][RC_LEDGER_COUNT];
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
