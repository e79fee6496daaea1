/* Reads: owners' records, tables of their beams (lidar_beam), air, volumes, shares of rays that surfaces stopped
 * (lidar_shots). Writes: rows of expected photons that air and particles send back once scattered, and their sums. One
 * work-item is one owner. Every bin is two cells of the whole way's length; a cell's light is taken at its Gauss point
 * on the middle ray, what particles scatter by their integral over the cell. Impulses of all bins come first, at two
 * phases, and are spread by the pulse's shares in one pass. Next: the host. */
#undef RC_ROW_WINDOW /* an option of lidar_shots: rows here are added up where they lie */
#include "kernels/lidar/context.h"
#include "kernels/lidar/beam.h"
#include "kernels/lidar/deposit.h"
#include "kernels/lidar/media.h"

#define LIDAR_AIR_PARAMETERS                                                                                     \
  global const float4 *restrict shots, global const uint *restrict beam_of, global const float *restrict tables, \
      global const float *restrict photons, global const float *restrict node_weight,                            \
      global const uint *restrict first_node, global const float2 *restrict air,                                 \
      global const float *restrict backscatter, RC_VOLUME_PARAMETERS, global const float *restrict taps,         \
      global const float *restrict settings, global const float *restrict stopped, global float *restrict rows,  \
      global float *restrict scratch, global float *restrict sums, int bins, int taps_used, int first_tap, int phases

#define RC_WAY_ROWS (RC_VOLUMES ? 2u : 1u)
#define RC_GAUSS_POINT 0.211324865f

#if RC_AIR
/* Backscatter of the air at heights, 1 / (m sr): linear between posts, nothing above the last. */
static inline float16 rc_backscatter(const LidarTables* t, global const float* posts, float16 z) {
  const float last = t->settings[RC_SET_AIR_POSTS] - 1.0f;
  const float16 x = (z - t->settings[RC_SET_AIR_Z0]) / t->settings[RC_SET_AIR_DZ], at = clamp(x, 0.0f, last),
                low = fmin(floor(at), fmax(last - 1.0f, 0.0f));
  RC_LINE float lane[16], from[16], to[16];
  rc_store16(low, 0, lane);
  if (lane[0] == lane[15]) { /* heights rise or fall along the ray */
    const uint i = (uint)lane[0];
    const float low_value = posts[i], high_value = last > 0.0f ? posts[i + 1u] : low_value;
    return select(fma(at - low, (float16)(high_value - low_value), (float16)(low_value)), (float16)(0.0f), x > last);
  }
  for (uint k = 0; k < 16u; ++k) {
    const uint i = (uint)lane[k];
    from[k] = posts[i];
    to[k] = last > 0.0f ? posts[i + 1u] : posts[i];
  }
  return select(fma(at - low, rc_load16(0, to) - rc_load16(0, from), rc_load16(0, from)), (float16)(0.0f), x > last);
}

/* Adds depths from a height on the ray's own way: rc_air_depths, quickly where all 16 heights lie in one cell. */
static inline void rc_way_depths(const LidarTables* t, float from_z, float16 to_z, float16 length, float16* depth) {
  const float z0 = t->settings[RC_SET_AIR_Z0], dz = t->settings[RC_SET_AIR_DZ];
  const uint posts = (uint)t->settings[RC_SET_AIR_POSTS];
  RC_LINE float z[16];
  rc_store16(to_z, 0, z);
  const int start = rc_air_cell(from_z, z0, dz, posts), a = rc_air_cell(z[0], z0, dz, posts),
            b = rc_air_cell(z[15], z0, dz, posts);
  if (a != b) {
    rc_air_depths(t, (float16)(from_z), to_z, length, depth);
    return;
  }
  const bool up = a > start;
  const int low = min(a, start), high = max(a, start);
  const float above_low = z0 + dz * (float)(low + 1), below_high = z0 + dz * (float)high;
  const float16 first = above_low - (up ? (float16)(from_z) : to_z),
                last = (up ? to_z : (float16)(from_z)) - below_high;
  const float16 whole = (first + last) + (below_high - above_low);
  for (uint node = 0; node < RC_LINE_NODES; ++node) {
    global const float2* cells = t->air + node * posts;
    if (low == high)
      depth[node] = fma(length, (float16)(cells[low].y), depth[node]);
    else
      depth[node] += length *
                     fma(first, (float16)(cells[low].y),
                         fma(last, (float16)(cells[high].y), (float16)(cells[high].x - cells[low + 1].x))) /
                     whole;
  }
}
#endif

/* 16 cells, one in each of 16 bins: Gauss points at bin + part. */
typedef struct Cells {
  float16 s, span, rest; /* m from the start; length; from the Gauss point to the end */
  float16 past; /* m, Gauss point from RC_SHOT_GATE, of small numbers alone: floats of s are 3 cm apart at 400 km */
  int16 good;
} Cells;

static inline Cells rc_cells(const LidarTables* t, const Beam* beam, int bin, float part) {
  const float16 lane =
      (float16)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f, 8.0f, 9.0f, 10.0f, 11.0f, 12.0f, 13.0f, 14.0f, 15.0f);
  const float step = 1.0f / t->settings[RC_SET_BINS_PER_M];
  const float16 bins = lane + ((float)bin + part),
                whole = fma(bins, (float16)(step), (float16)(t->settings[RC_SET_GATE_WAY]));
  const float4 at_gate = t->shot[RC_SHOT_GATE_WAY];
  Cells cells;
  cells.s = rc_beam_distance(beam, fmax(whole, 0.0f));
  /* s = (whole - along) / 2 - beside / (2 (whole + along)), its difference from the gate's. */
  const float16 both = fmax((whole + beam->along) * (at_gate.x + beam->along), 1e-20f);
  cells.past = 0.5f * step * (bins - at_gate.y) * (1.0f + beam->beside / both);
  cells.rest = fmax(whole - cells.s, 1e-20f);
  /* d whole / d s = 1 + the cosine between the ray and the way back from the end. */
  cells.span = 0.5f * step / fmax(1.0f + (cells.s + beam->along) / cells.rest, 1e-6f);
  cells.good = (cells.s > 0.0f) & (cells.s <= t->settings[RC_SET_RANGE_LIMIT]) &
               ((RC_RECEIVER ? cells.s : cells.rest) >= t->settings[RC_SET_MINIMUM_RANGE]);
  return cells;
}

/* The table at distances, over the square of the distance to the end. */
static inline float16 rc_geometry(global const float* table, const Cells* cells) {
  const float log_near = table[RC_BEAM_LOG_NEAR], per_log = table[RC_BEAM_POSTS_PER_LOG];
  const float16 at = clamp((log(fmax(cells->s, 1e-20f)) - log_near) * per_log, 0.0f, table[RC_BEAM_LAST]),
                low = floor(at);
  RC_LINE float lane[16], from[16], to[16];
  rc_store16(low, 0, lane);
  float16 a, b;
  if (lane[0] == lane[15]) { /* distances rise */
    a = table[(uint)lane[0]];
    b = table[(uint)lane[0] + 1u];
  } else {
    for (uint k = 0; k < 16u; ++k) {
      const uint post = (uint)lane[k];
      from[k] = table[post];
      to[k] = table[post + 1u];
    }
    a = rc_load16(0, from);
    b = rc_load16(0, to);
  }
#if RC_OVERLAP && !RC_RECEIVER && RC_COLUMNS * RC_ROWS == 1
  /* Where nothing is seen from one of two posts, the edge of a blind zone lies between: nothing leaks into it. */
  const int16 open = cells->good & (a > 0.0f) & (b > 0.0f);
#else
  const int16 open = cells->good;
#endif
  /* Nearer than the table: eta / R^2 stays. */
  const float16 rest = cells->rest * fmax(exp(log_near) / fmax(cells->s, 1e-20f), 1.0f);
  return select((float16)(0.0f), fma(at - low, b - a, a) / (rest * rest), open);
}

#if RC_VOLUMES
/* Volumes along the middle ray, cell after cell. */
typedef struct Swept {
  float came_to, too_far; /* m from RC_SHOT_GATE, and how much rounding added to it */
  float depth[RC_LINE_NODES],
      lost[RC_LINE_NODES]; /* and what rounding took of its sum (Kahan): 1e-4 of it over 20000 bins */
} Swept;

static inline void rc_deepen(Swept* swept, uint node, float more) {
  const float whole = more - swept->lost[node], sum = swept->depth[node] + whole;
  swept->lost[node] = (sum - swept->depth[node]) - whole;
  swept->depth[node] = sum;
}

/* Depths at the cells' Gauss points and what particles scatter in each cell, integrated over it. */
static inline void rc_sweep(const LidarTables* t, const Beam* beam, const Cells* cells, float part, Swept* swept,
                            float16* depth, float16* particles) {
  RC_LINE float s[16], span[16], scattered[16];
  RC_LINE float here[RC_LINE_NODES][16];
  const float4 gate = t->shot[RC_SHOT_GATE];
  const uint exists = rc_mask16(cells->s > 0.0f);
  rc_store16(cells->past, 0, s);
  rc_store16(cells->span, 0, span);
  for (uint k = 0; k < 16u; ++k) {
    scattered[k] = 0.0f;
    for (uint node = 0; node < RC_LINE_NODES; ++node) here[node][k] = swept->depth[node];
    if (!(exists >> k & 1u)) continue;
    const float from = fmax(s[k] - part * span[k], -gate.w), before = (from - swept->came_to) + swept->too_far;
    const float4 at = (float4)(gate.xyz, 0.0f) + from * beam->way;
    float cell[RC_LINE_NODES];
    for (uint node = 0; node < RC_LINE_NODES; ++node) cell[node] = 0.0f;
    for (uint i = 0; i < RC_VOLUMES; ++i) {
      if (before > 0.01f * span[k]) { /* the first cell begins past the start */
        const float gap = rc_volume_path(t->volumes + i, t->volume_values, at, beam->way, -before, 0.0f);
        for (uint node = 0; node < RC_LINE_NODES; ++node) rc_deepen(swept, node, rc_volume_depth(t, i, node, gap));
      }
      const float field = rc_volume_path(t->volumes + i, t->volume_values, at, beam->way, 0.0f, span[k]);
      scattered[k] +=
          t->volumes[i].particles.x > 0.0f ? field * t->volumes[i].particles.x / t->volumes[i].particles.z : 0.0f;
      for (uint node = 0; node < RC_LINE_NODES; ++node) cell[node] += rc_volume_depth(t, i, node, field);
    }
    for (uint node = 0; node < RC_LINE_NODES; ++node) {
      here[node][k] = fma(part, cell[node], swept->depth[node]);
      rc_deepen(swept, node, cell[node]);
    }
    swept->came_to = from + span[k];
    swept->too_far = (swept->came_to - from) - span[k];
  }
  for (uint node = 0; node < RC_LINE_NODES; ++node) depth[node] += rc_load16(0, here[node]);
  *particles = rc_load16(0, scattered);
}
#endif

/* Impulses of 16 bins, at two phases, to their place by the slot where their shares start. Bins whose pulse lies
 * outside the gate are left out. */
static inline void rc_put(const LidarTables* t, global float* impulses, uint line_floats, float sums[RC_SUM_COUNT][2],
                          int bin, const float16* energy) {
  const int16 start = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) + (bin + t->first_tap);
  const int16 in = (start + t->tap_count > 0) & (start < t->bins);
  const float16 a = select((float16)(0.0f), energy[0], in), b = select((float16)(0.0f), energy[1], in);
  rc_add_float(sums[RC_SUM_COLLECTED], rc_lane_sum(a + b));
  global float* to = impulses + RC_TAPS_PADDED + RC_ROW_PAD + bin + t->first_tap;
  rc_store16(a, 0, to);
  rc_store16(b, 0, to + line_floats);
}

RC_BODY lidar_air_body(uint owner, LIDAR_AIR_PARAMETERS) {
  const uint row_floats = rc_row_floats((uint)bins);
  const LidarTables all = {shots + (size_t)owner * RC_SHOT_FLOAT4S,
                           0,
                           0,
                           0,
                           0,
                           photons,
                           node_weight,
                           first_node,
                           air,
                           volumes,
                           volume_values,
                           volume_depth,
                           taps,
                           settings,
                           0,
                           row_floats,
                           bins,
                           taps_used,
                           first_tap,
                           phases};
  const LidarTables* t = &all;
  const Beam beam = rc_beam(t);
  const size_t own_rows = (size_t)RC_OWN_PIXELS * RC_LASER_LINES;
  global float* own = rows + (size_t)owner * RC_WAY_ROWS * own_rows * row_floats; /* air, then particles */
  /* Impulses, [kind][line][phase], and shares of bins at their two phases. */
  const uint line_floats = row_floats + RC_TAPS_PADDED;
  global float* impulses = scratch + (size_t)owner * RC_WAY_ROWS * 2u * RC_LASER_LINES * line_floats;
  float share[2][RC_TAPS_PADDED];
  for (uint g = 0; g < 2u; ++g) {
    const float x = (g ? 1.0f - RC_GAUSS_POINT : RC_GAUSS_POINT) * (float)phases;
    const int q = min((int)x, phases - 1);
    for (int i = 0; i < RC_TAPS_PADDED; ++i) {
      const float low = taps[q * RC_TAPS_PADDED + i], high = taps[(q + 1) * RC_TAPS_PADDED + i];
      share[g][i] = fma(x - (float)q, high - low, low);
    }
  }
  float total[RC_LASER_LINES][RC_SUM_COUNT][2];
  for (uint line = 0; line < RC_LASER_LINES; ++line)
    for (uint i = 0; i < RC_SUM_COUNT; ++i) total[line][i][0] = total[line][i][1] = 0.0f;
  const bool apart = beam.squared > 0.0f;
  const float weight = t->shot[RC_SHOT_DU].w;

  for (uint pixel = 0; pixel < RC_OWN_PIXELS; ++pixel) {
    global const float* table = tables + ((size_t)beam_of[owner] * RC_OWN_PIXELS + pixel) * RC_BEAM_FLOATS;
    for (uint i = 0; i < RC_WAY_ROWS * 2u * RC_LASER_LINES * line_floats; i += 16u)
      rc_store16((float16)(0.0f), 0, impulses + i);
    /* Rays stopped: of a pixel's own, or of all. */
    const bool own_rays = rc_stops_by_pixel(t);
    global const float* of_owner = stopped + owner * rc_stopped_floats(row_floats);
    global const float* gone = of_owner + (own_rays ? (size_t)pixel * RC_LASER_LINES * row_floats : 0);
    const float one = 1.0f / (own_rays ? fmax(of_owner[own_rows * row_floats + pixel], 1.0f) : (float)RC_RAY_COUNT);
    float ended[RC_LASER_LINES];
    for (uint line = 0; line < RC_LASER_LINES; ++line) ended[line] = 0.0f;
#if RC_VOLUMES
    Swept swept[2]; /* the two cells of a bin are one behind the other: each chain sweeps all */
    for (uint g = 0; g < 2u; ++g) {
      swept[g].came_to = -t->shot[RC_SHOT_GATE].w;
      swept[g].too_far = 0.0f;
      for (uint node = 0; node < RC_LINE_NODES; ++node) swept[g].depth[node] = swept[g].lost[node] = 0.0f;
    }
#endif
    for (int bin = -RC_ROW_PAD; bin < t->bins + RC_ROW_PAD; bin += 16) {
      float16 lit[RC_LASER_LINES];
      for (uint line = 0; line < RC_LASER_LINES; ++line) {
        RC_LINE float lane[16];
        for (uint k = 0; k < 16u; ++k) {
          const int slot = bin + (int)k + RC_ROW_PAD;
          if (slot < (int)row_floats) ended[line] += gone[line * row_floats + slot];
          lane[k] = ended[line];
        }
        lit[line] = fmax(1.0f - rc_load16(0, lane) * one, 0.0f);
      }
      float16 of_air[RC_LASER_LINES][2], of_particles[RC_LASER_LINES][2];
      for (uint g = 0; g < 2u; ++g) {
        const float part = g ? 1.0f - RC_GAUSS_POINT : RC_GAUSS_POINT;
        const Cells cells = rc_cells(t, &beam, bin, part);
        const float16 geometry = rc_geometry(table, &cells);
#if RC_AIR
        const float16 z = fma(cells.past, (float16)(beam.way.z), (float16)(t->shot[RC_SHOT_GATE].z));
#endif
        float16 depth[RC_LINE_NODES];
        for (uint node = 0; node < RC_LINE_NODES; ++node) depth[node] = 0.0f;
#if RC_AIR
        rc_way_depths(t, beam.start.z, z, cells.s, depth);
#endif
#if RC_VOLUMES
        float16 particles;
        rc_sweep(t, &beam, &cells, g ? 2.0f * part - 1.0f : 2.0f * part, &swept[g], depth, &particles);
#endif
        if (!apart) {
          for (uint node = 0; node < RC_LINE_NODES; ++node) depth[node] *= 2.0f;
        } else {
#if RC_AIR
          rc_way_depths(t, beam.start.z - beam.apart.z, z, cells.rest, depth);
#endif
#if RC_VOLUMES
          const float16 inverse = 1.0f / cells.rest;
          const float4 end_at = beam.start - beam.apart;
          const Vector16 end = {(float16)(end_at.x), (float16)(end_at.y), (float16)(end_at.z)};
          const Vector16 unit = {-fma(cells.s, (float16)(beam.way.x), (float16)(beam.apart.x)) * inverse,
                                 -fma(cells.s, (float16)(beam.way.y), (float16)(beam.apart.y)) * inverse,
                                 -fma(cells.s, (float16)(beam.way.z), (float16)(beam.apart.z)) * inverse};
          rc_volume_depths(t, end, unit, cells.rest, rc_mask16(cells.good), depth);
#endif
        }
        for (uint line = 0; line < RC_LASER_LINES; ++line) {
          const float16 arrives =
              geometry * (weight * t->photons[line]) * rc_line_transmission(t, line, depth) * lit[line];
          of_air[line][g] = of_particles[line][g] = 0.0f;
          (void)arrives;
#if RC_AIR_RETURN
          of_air[line][g] =
              arrives * cells.span * rc_backscatter(t, backscatter + line * (uint)settings[RC_SET_AIR_POSTS], z);
#endif
#if RC_VOLUMES
          of_particles[line][g] = arrives * particles;
#endif
        }
      }
      for (uint line = 0; line < RC_LASER_LINES; ++line) {
        rc_put(t, impulses + line * 2u * line_floats, line_floats, total[line], bin, of_air[line]);
#if RC_VOLUMES
        rc_put(t, impulses + (RC_LASER_LINES + line) * 2u * line_floats, line_floats, total[line], bin,
               of_particles[line]);
#endif
      }
    }
    /* Spread by the pulse in one pass: adding bin by bin, every store would overlap the next load. */
    for (uint kind = 0; kind < RC_WAY_ROWS; ++kind)
      for (uint line = 0; line < RC_LASER_LINES; ++line) {
        global float* row = own + (kind * own_rows + pixel * RC_LASER_LINES + line) * row_floats;
        global const float* from = impulses + (kind * RC_LASER_LINES + line) * 2u * line_floats + RC_TAPS_PADDED;
        for (uint slot = 0; slot < row_floats; slot += 16u) {
          float16 sum = 0.0f;
          for (int i = 0; i < taps_used; ++i) {
            global const float* at = from + (int)slot - i;
            sum = fma((float16)(share[0][i]), rc_load16(0, at),
                      fma((float16)(share[1][i]), rc_load16(0, at + line_floats), sum));
          }
          rc_store16(sum, 0, row + slot);
        }
      }
  }
  for (uint line = 0; line < RC_LASER_LINES; ++line) {
    for (uint kind = 0; kind < RC_WAY_ROWS; ++kind)
      for (uint pixel = 0; pixel < RC_OWN_PIXELS; ++pixel)
        rc_close_row(t, own + (kind * own_rows + pixel * RC_LASER_LINES + line) * row_floats, total[line]);
    for (uint i = 0; i < RC_SUM_COUNT; ++i) {
      const size_t at = ((size_t)owner * RC_LASER_LINES + line) * RC_SUM_COUNT + i;
      sums[2u * at] = total[line][i][0];
      sums[2u * at + 1u] = total[line][i][1];
    }
  }
}

kernel void lidar_air(LIDAR_AIR_PARAMETERS) {
  lidar_air_body((uint)get_global_id(0), shots, beam_of, tables, photons, node_weight, first_node, air, backscatter,
                 volumes, volume_values, volume_depth, taps, settings, stopped, rows, scratch, sums, bins, taps_used,
                 first_tap, phases);
}
