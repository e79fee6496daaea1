/* How host and device name the numbers of a LIDAR's launch. Valid C++20 and OpenCL C 1.2. An owner is what one
 * work-item computes: a shot (transmitter sampling) or a pixel of a shot (receiver sampling). */
#ifndef RAYCUBE_KERNELS_LIDAR_LAYOUT_H
#define RAYCUBE_KERNELS_LIDAR_LAYOUT_H

/* float4s of an owner's record. Q is a point on the middle ray near the scene, at distance s from where it starts;
 * points are kept relative to Q, so that only small numbers are rounded. A ray is Q + s (a du + b dv) + exit offset +
 * tau (axis + a du + b dv). "start": where rays start (exit, or pupil in receiver sampling); "end": where connections
 * go (pupil, or exit). */
enum {
  RC_SHOT_START, /* xyz: start, m;  w: s, m */
  /* xyz: direction of the middle ray, unit (receiver: third component along the pupil's axis is 1);  w: 1 where start
   * and end are one point */
  RC_SHOT_AXIS,
  /* xyz: change of direction per unit of a;  w: weight: share of each ray, all constant factors but photons */
  RC_SHOT_DU,
  RC_SHOT_DV,
  RC_SHOT_REFERENCE,  /* xyz: Q rounded;  w: how far back single rays start, m */
  RC_SHOT_RESIDUAL,   /* xyz: Q minus Q rounded */
  RC_SHOT_FROM_START, /* xyz: Q - start;  w: its length */
  RC_SHOT_FROM_END,   /* xyz: Q - end;  w: its length */
  RC_SHOT_END_AXIS,   /* xyz: axis at the end (transmitter: pupil's, receiver: exit's);  w: exit radius, m (receiver) */
  RC_SHOT_END_U,      /* xyz: pupil's u, v (transmitter), for arrays;  w: tan(half divergence) (receiver) */
  RC_SHOT_END_V,
  RC_SHOT_START_AXIS, /* xyz: axis at the start */
  RC_SHOT_EXIT_U,     /* xyz: exit radius times u, v: where a sub-ray leaves, per unit of exit_a, exit_b */
  RC_SHOT_EXIT_V,
  /* x: bits of the int bin of path |from start| + |from end|;  y: position in that bin;  z: bits of the draw key */
  RC_SHOT_TIME,
  /* where the middle ray is when the gate opens (at its start, if that comes later). xyz: place, m;  w: m from the
   * start */
  RC_SHOT_GATE,
  /* x: whole way over it and on to the end, m;  y: position in bins, 0 but where the ray starts later */
  RC_SHOT_GATE_WAY,
  RC_SHOT_FLOAT4S
};

/* What a launch may have. Its argument `plan` says what it has, the build option RC_FEATURES what a program can do: one
 * of the sets below. A branch that the option leaves open is the same for all work-items. */
#define RC_FEATURE_RECEIVER 0x1u    /* rays from the pupil (samples of a pixel), not from the exit (sub-rays) */
#define RC_FEATURE_SINGLE 0x2u      /* single rays (narrow beams, exits of their own), not bundles */
#define RC_FEATURE_EXITS 0x4u       /* every sub-ray leaves from a place of its own */
#define RC_FEATURE_PIXELS 0x8u      /* an owner has several pixels (transmitter); else there is the circular stop */
#define RC_FEATURE_OVERLAP 0x10u    /* vignetting */
#define RC_FEATURE_GAUSSIAN 0x20u   /* profile of the beam (receiver) */
#define RC_FEATURE_HITS 0x40u       /* first hits are written */
#define RC_FEATURE_FOLDED 0x80u     /* hits are kept as moments of their bins, spread once an owner (moments.h) */
#define RC_FEATURE_LEAVES 0x100u    /* some material lets light through diffusely */
#define RC_FEATURE_PLATES 0x200u    /* some material lets light through straight on */
#define RC_FEATURE_GLOSS 0x400u     /* some material is glossy */
#define RC_FEATURE_SHAPED 0x800u    /* some material does not reflect by Lambert's law */
#define RC_FEATURE_BOUNCES 0x1000u  /* light is followed past its first scattering */
#define RC_FEATURE_SHADOWS 0x2000u  /* some shot's ends differ: connections of the first vertex are traced */
#define RC_FEATURE_AIR 0x4000u      /* there is air */
#define RC_FEATURE_VOLUMES 0x8000u  /* there are volumes of gas or particles */
#define RC_FEATURE_RETURN 0x10000u  /* the air sends light back (lidar_air) */
#define RC_FEATURE_STOPPED 0x20000u /* shares of rays stopped are written, for lidar_air */
#define RC_FEATURE_RESTS 0x40000u   /* bins of several pixels are sums of two floats: many sub-rays fall into one */
/* Sets of them that programs are built for: shots of one line whose light comes back the way it went; the same with air
 * and a receiver beside the laser; everything. */
#define RC_FEATURES_PLAIN                                                                              \
  (RC_FEATURE_SINGLE | RC_FEATURE_EXITS | RC_FEATURE_OVERLAP | RC_FEATURE_GAUSSIAN | RC_FEATURE_HITS | \
   RC_FEATURE_FOLDED | RC_FEATURE_LEAVES)
#define RC_FEATURES_SURVEY \
  (RC_FEATURES_PLAIN | RC_FEATURE_SHADOWS | RC_FEATURE_AIR | RC_FEATURE_RETURN | RC_FEATURE_STOPPED)
#define RC_FEATURES_ALL 0x7FFFFu

/* Spectral nodes that a program has room for with so many lines (RC_MOST_LINES). */
#define RC_NODES_OF_ROOM(lines) ((lines) == 1 ? 1 : 4 * (lines))

/* Counts of a launch, its argument `plan`. */
enum {
  RC_PLAN_FEATURES,
  RC_PLAN_LINES,
  RC_PLAN_NODES, /* spectral nodes of all lines */
  RC_PLAN_COLUMNS,
  RC_PLAN_ROWS,    /* pixels of the array */
  RC_PLAN_RAYS,    /* of an owner */
  RC_PLAN_SLOTS,   /* of a bundle, struct Scatter */
  RC_PLAN_BOUNCES, /* scatterings that a path may have */
  RC_PLAN_VOLUMES,
  RC_PLAN_TAPS,        /* of the pulse, rounded up to 16 */
  RC_PLAN_LOBE_LINES,  /* lines whose lobes have shares of their own; 1: all share them */
  RC_PLAN_LOBE_STRIDE, /* lobes of a surface and such a line */
  RC_PLAN_COUNT
};

/* Settings of a launch, floats. */
enum {
  RC_SET_BINS_PER_M, /* group index / (c bin) */
  RC_SET_HALF_FOV,   /* rad, circular field stop */
  RC_SET_PUPIL,      /* radii of pupil and obscuration, m */
  RC_SET_OBSCURATION,
  RC_SET_FOCUS,         /* 1 / distance in focus, 1 / m */
  RC_SET_PITCH,         /* rad, of an array */
  RC_SET_MINIMUM_RANGE, /* m */
  RC_SET_RANGE_LIMIT,   /* m; INFINITY: none */
  RC_SET_AIR_Z0,        /* m, first post; spacing, m */
  RC_SET_AIR_DZ,
  RC_SET_AIR_POSTS,
  RC_SET_GATE_WAY, /* m, whole way at the start of bin 0 */
  RC_SET_SUPPORT,  /* width of the square that sub-rays cover, in units of a and b */
  RC_SET_COUNT
};

/* Table of a beam, floats: how much of it reaches the end from distances along its middle ray (beam.h). Up to RC_POSTS
 * posts, 1 % apart (1.08 % over the six decades that a table may span). */
#define RC_POSTS 1280
enum { RC_BEAM_LOG_NEAR = RC_POSTS + 1, RC_BEAM_POSTS_PER_LOG, RC_BEAM_LAST, RC_BEAM_FLOATS = RC_POSTS + 16 };

/* Moments that a pulse's shares are polynomials in (host/lidar/pulse_moments.h). */
#define RC_MOMENTS 6
/* Lines whose moments a work-item keeps, at most: 9 KiB each. */
#define RC_FOLDED_LINES 4

/* Ledger of an owner and line, 64-bit integers, in units of 2^-40 of what it emits. */
enum { RC_LEDGER_ABSORBED, RC_LEDGER_AIR, RC_LEDGER_VOLUMES, RC_LEDGER_ESCAPED, RC_LEDGER_TRUNCATED, RC_LEDGER_COUNT };
#define RC_LEDGER_BITS 40
/* Sums of an owner and line, photons, each as two floats (sum, rest). */
enum { RC_SUM_COLLECTED, RC_SUM_EARLY, RC_SUM_LATE, RC_SUM_NEAR, RC_SUM_COUNT };

#endif
