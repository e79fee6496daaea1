/* Reads: owners' records, air, volumes, shares of rays that surfaces stopped (lidar_shots). Writes: rows of expected photons that air and
 * particles send back once scattered, and their sums. One work-item is one owner. Every bin is two cells of the whole way's length; a
 * cell's light is taken at its Gauss point on the middle ray, what particles scatter by their integral over the cell; the beam's width
 * enters by tables of its sub-rays' mean at places whose distances rise geometrically, 1 % apart (farther in gates of more than a
 * factor 13). Impulses of all bins come first, at two phases, and are spread by the pulse's shares in one pass. Next: the host. */
#include "kernels/lidar/context.h"
#include "kernels/lidar/beam.h"
#include "kernels/lidar/deposit.h"
#include "kernels/lidar/media.h"

#define LIDAR_AIR_PARAMETERS global const float4* restrict shots, global const float* restrict samples, global const float* restrict exits, \
  global const float* restrict photons, global const float* restrict node_weight, global const uint* restrict first_node, \
  global const float2* restrict air, global const float* restrict backscatter, RC_VOLUME_PARAMETERS, global const float* restrict taps, \
  global const float* restrict settings, global const float* restrict stopped, global float* restrict rows, global float* restrict scratch, global float* restrict sums, \
  int bins, int taps_used, int first_tap, int phases

#if RC_AIR
/* Backscatter of the air at a height, 1 / (m sr): linear between posts. */
static inline float rc_backscatter(const LidarTables* t, global const float* posts, float z) {
  const float last = t->settings[RC_SET_AIR_POSTS] - 1.0f, x = (z - t->settings[RC_SET_AIR_Z0]) / t->settings[RC_SET_AIR_DZ];
  if (x > last) return 0.0f;
  const float at = fmax(x, 0.0f), low = fmin(floor(at), fmax(last - 1.0f, 0.0f));
  const uint i = (uint)low;
  return last > 0.0f ? fma(at - low, posts[i + 1u] - posts[i], posts[i]) : posts[0];
}
#endif

/* Cells of 8 bins: where they lie on the middle ray. */
typedef struct Cells {
  float s[16], from[16], to[16];   /* Gauss point and ends, m from the start */
  float rest[16];                  /* m, Gauss point to the end */
} RC_LINE Cells;

static inline void rc_cells(const LidarTables* t, const Beam* beam, int bin, Cells* cells) {
  const float16 lane = (float16)(0.0f, 0.0f, 1.0f, 1.0f, 2.0f, 2.0f, 3.0f, 3.0f, 4.0f, 4.0f, 5.0f, 5.0f, 6.0f, 6.0f, 7.0f, 7.0f);
  const float16 half_bin = (float16)(0.0f, 0.5f, 0.0f, 0.5f, 0.0f, 0.5f, 0.0f, 0.5f, 0.0f, 0.5f, 0.0f, 0.5f, 0.0f, 0.5f, 0.0f, 0.5f);
  const float16 gauss = (float16)(0.211324865f, 0.788675135f, 0.211324865f, 0.788675135f, 0.211324865f, 0.788675135f, 0.211324865f, 0.788675135f,
                                  0.211324865f, 0.788675135f, 0.211324865f, 0.788675135f, 0.211324865f, 0.788675135f, 0.211324865f, 0.788675135f);
  const float way = t->settings[RC_SET_GATE_WAY], step = 1.0f / t->settings[RC_SET_BINS_PER_M], limit = t->settings[RC_SET_RANGE_LIMIT];
  const float16 first = lane + (float)bin;
  const float16 whole = fma(first + gauss, (float16)(step), (float16)(way)), s = rc_beam_distance(beam, fmax(whole, 0.0f));
  rc_store16(s, 0, cells->s);
  rc_store16(whole - s, 0, cells->rest);
  rc_store16(fmin(rc_beam_distance(beam, fmax(fma(first + half_bin, (float16)(step), (float16)(way)), 0.0f)), limit), 0, cells->from);
  rc_store16(fmin(rc_beam_distance(beam, fmax(fma(first + half_bin + 0.5f, (float16)(step), (float16)(way)), 0.0f)), limit), 0, cells->to);
}

RC_BODY lidar_air_body(uint owner, LIDAR_AIR_PARAMETERS) {
  const uint row_floats = rc_row_floats((uint)bins);
  const LidarTables tables = {shots + (size_t)owner * RC_SHOT_FLOAT4S, samples, exits, 0, 0, photons, node_weight, first_node, air, volumes, volume_values, volume_depth, taps, settings, 0, row_floats, bins, taps_used, first_tap, phases};
  const LidarTables* t = &tables;
  const Beam beam = rc_beam(t);
  const size_t own_rows = (size_t)RC_OWN_PIXELS * RC_LASER_LINES;
  global float* own = rows + (size_t)owner * 2u * own_rows * row_floats;  /* air, then particles */
  for (size_t i = 0; i < 2u * own_rows * row_floats; i += 16) rc_store16((float16)(0.0f), 0, own + i);
  float total[RC_LASER_LINES][RC_SUM_COUNT][2];
  for (uint line = 0; line < RC_LASER_LINES; ++line)
    for (uint i = 0; i < RC_SUM_COUNT; ++i) total[line][i][0] = total[line][i][1] = 0.0f;

  /* Posts of the table. */
  Cells ends;
  rc_cells(t, &beam, t->bins + RC_ROW_PAD - 8, &ends);
  const float far = fmax(ends.to[15], 1e-3f);
  rc_cells(t, &beam, -RC_ROW_PAD, &ends);
  const float near = fmax(fmax(ends.from[0], 1e-3f * far), fmin(settings[RC_SET_MINIMUM_RANGE], far));
  const float log_near = log(near), log_span = fmax(log(far) - log_near, 1e-6f);
  const uint posts = (uint)clamp(100.0f * log_span + 2.0f, 4.0f, (float)RC_POSTS);
  const float posts_per_log = (float)(posts - 1u) / log_span;
  /* Shares of bins at the cells' two phases. */
  float share[2][RC_TAPS_PADDED];
  for (uint phase = 0; phase < 2u; ++phase) {
    const float x = (phase ? 0.788675135f : 0.211324865f) * (float)phases;
    const int q = min((int)x, phases - 1);
    for (int i = 0; i < RC_TAPS_PADDED; ++i) {
      const float low = taps[q * RC_TAPS_PADDED + i], high = taps[(q + 1) * RC_TAPS_PADDED + i];
      share[phase][i] = fma(x - (float)q, high - low, low);
    }
  }
  /* Impulses, [kind][line][phase], by the slot where their shares start. */
  const uint line_floats = row_floats + RC_TAPS_PADDED;
  global float* impulses = scratch + (size_t)owner * 4u * RC_LASER_LINES * line_floats;
  const int begin = -RC_ROW_PAD - first_tap;  /* bin of the first cells whose shares reach the gate */
  const bool apart = beam.squared > 0.0f;
  const float weight = t->shot[RC_SHOT_DU].w;

  for (uint pixel = 0; pixel < RC_OWN_PIXELS; ++pixel) {
    float table[RC_POSTS + 1];
    bool any = false;
    for (uint i = 0; i < posts; ++i) {
      table[i] = rc_beam_sum(t, &beam, exp(fma((float)i, 1.0f / posts_per_log, log_near)), (float)pixel);
      any |= table[i] > 0.0f;
    }
    table[posts] = table[posts - 1u];
    if (!any) continue;
    float ended[RC_LASER_LINES];
    float16 depth_to[RC_LINE_NODES];                  /* of volumes, up to where the cells have come */
    for (uint line = 0; line < RC_LASER_LINES; ++line) {
      ended[line] = 0.0f;
      for (int slot = 0; slot < min(begin + RC_ROW_PAD, (int)row_floats); ++slot) ended[line] += stopped[((size_t)owner * RC_LASER_LINES + line) * row_floats + slot];
    }
    for (size_t i = 0; i < (size_t)4u * RC_LASER_LINES * line_floats; i += 16) rc_store16((float16)(0.0f), 0, impulses + i);
    RC_LINE float volumes_to[RC_LINE_NODES][16];
    float volumes_sum[RC_LINE_NODES];
    for (uint node = 0; node < RC_LINE_NODES; ++node) volumes_sum[node] = 0.0f;
#if RC_VOLUMES
    float came_to = 0.0f;
#endif

    for (int bin = begin; bin + first_tap < t->bins; bin += 8) {
      Cells cells;
      rc_cells(t, &beam, bin, &cells);
      RC_LINE float post_at[16];
      rc_store16(clamp((log(fmax(vload16(0, cells.s), near)) - log_near) * posts_per_log, 0.0f, (float)(posts - 1u)), 0, post_at);
      RC_LINE float geometry[16], beta[RC_LASER_LINES][16], particles[16], z[16], dead[RC_LASER_LINES][16];
      uint lanes = 0;
      for (uint k = 0; k < 16u; ++k) {
        const int slot = bin + (int)(k / 2u) + RC_ROW_PAD;
        for (uint line = 0; line < RC_LASER_LINES; ++line) {
          if (!(k & 1u) && slot >= 0 && slot < (int)row_floats) ended[line] += stopped[((size_t)owner * RC_LASER_LINES + line) * row_floats + slot];
          dead[line][k] = ended[line];
        }
        geometry[k] = particles[k] = 0.0f;
        for (uint node = 0; node < RC_LINE_NODES; ++node) volumes_to[node][k] = 0.0f;
        const float s = cells.s[k], from_pupil = RC_RECEIVER ? s : cells.rest[k], span = cells.to[k] - cells.from[k];
        z[k] = fma(s, beam.way.z, beam.start.z);
        for (uint line = 0; line < RC_LASER_LINES; ++line) beta[line][k] = 0.0f;
        if (!(span > 0.0f)) continue;
#if RC_VOLUMES
        const float ahead = cells.from[k] - came_to;   /* the first cell begins past the start */
        for (uint i = 0; i < RC_VOLUMES; ++i) {
          if (ahead > 0.0f) {
            const float before = rc_volume_path(volumes + i, volume_values, beam.start, beam.way, came_to, cells.from[k]);
            for (uint node = 0; node < RC_LINE_NODES; ++node) volumes_sum[node] += rc_volume_depth(t, i, node, before);
          }
          const float field = rc_volume_path(volumes + i, volume_values, beam.start, beam.way, cells.from[k], cells.to[k]);
          particles[k] += volumes[i].particles.x > 0.0f ? field * volumes[i].particles.x / volumes[i].particles.z : 0.0f;
          for (uint node = 0; node < RC_LINE_NODES; ++node) volumes_to[node][k] += rc_volume_depth(t, i, node, field);
        }
        const float part = clamp((s - cells.from[k]) / span, 0.0f, 1.0f);
        for (uint node = 0; node < RC_LINE_NODES; ++node) {
          const float here = volumes_to[node][k];
          volumes_to[node][k] = fma(part, here, volumes_sum[node]);
          volumes_sum[node] += here;
        }
        came_to = cells.to[k];
#endif
        if (from_pupil < settings[RC_SET_MINIMUM_RANGE] || !(cells.rest[k] > 0.0f)) continue;
        const float at = post_at[k];
        const uint post = (uint)at;
        geometry[k] = fma(at - (float)post, table[post + 1u] - table[post], table[post]) / (cells.rest[k] * cells.rest[k]);
#if RC_AIR
        for (uint line = 0; line < RC_LASER_LINES; ++line) beta[line][k] = span * rc_backscatter(t, backscatter + line * (uint)settings[RC_SET_AIR_POSTS], z[k]);
#endif
        lanes |= geometry[k] > 0.0f ? 1u << k : 0u;
      }
      if (!lanes) continue;
      for (uint node = 0; node < RC_LINE_NODES; ++node) depth_to[node] = 0.0f;
#if RC_AIR
      const float16 height = vload16(0, z);
      rc_air_depths(t, (float16)(beam.start.z), height, vload16(0, cells.s), depth_to);
#endif
      for (uint node = 0; node < RC_LINE_NODES; ++node) depth_to[node] += vload16(0, volumes_to[node]);
      if (!apart) {
        for (uint node = 0; node < RC_LINE_NODES; ++node) depth_to[node] *= 2.0f;
      } else {
#if RC_AIR
        rc_air_depths(t, height, (float16)(beam.start.z - beam.apart.z), vload16(0, cells.rest), depth_to);
#endif
#if RC_VOLUMES
        const float16 s = vload16(0, cells.s), inverse = 1.0f / fmax(vload16(0, cells.rest), 1e-20f);
        const Vector16 back = {-fma(s, (float16)(beam.way.x), (float16)(beam.apart.x)), -fma(s, (float16)(beam.way.y), (float16)(beam.apart.y)),
                               -fma(s, (float16)(beam.way.z), (float16)(beam.apart.z))};
        const float4 end_at = beam.start - beam.apart;
        const Vector16 end = {(float16)(end_at.x), (float16)(end_at.y), (float16)(end_at.z)}, unit = {back.x * inverse, back.y * inverse, back.z * inverse};
        rc_volume_depths(t, end, unit, vload16(0, cells.rest), lanes, depth_to);
#endif
      }
      for (uint line = 0; line < RC_LASER_LINES; ++line) {
        const float16 arrives = vload16(0, geometry) * (weight * t->photons[line]) * rc_line_transmission(t, line, depth_to) * fmax(1.0f - vload16(0, dead[line]), 0.0f);
        for (uint kind = RC_AIR ? 0u : 1u; kind < (RC_VOLUMES ? 2u : 1u); ++kind) {
          const float16 energy = select((float16)(0.0f), fmax(arrives * vload16(0, kind ? particles : beta[line]), 0.0f), rc_bits16(lanes));
          rc_add_float(total[line][RC_SUM_COLLECTED], rc_lane_sum(energy));
          global float* to = impulses + (kind * RC_LASER_LINES + line) * 2u * line_floats + RC_TAPS_PADDED + RC_ROW_PAD + bin + first_tap;
          vstore8(energy.even, 0, to);
          vstore8(energy.odd, 0, to + line_floats);
        }
      }
    }
    for (uint kind = RC_AIR ? 0u : 1u; kind < (RC_VOLUMES ? 2u : 1u); ++kind)
      for (uint line = 0; line < RC_LASER_LINES; ++line) {
        global float* row = own + (kind * own_rows + pixel * RC_LASER_LINES + line) * row_floats;
        global const float* from = impulses + (kind * RC_LASER_LINES + line) * 2u * line_floats + RC_TAPS_PADDED;
        for (uint slot = 0; slot < row_floats; slot += 16u) {
          float16 sum = 0.0f;
          for (int i = 0; i < taps_used; ++i) {
            global const float* at = from + (int)slot - i;
            sum = fma((float16)(share[0][i]), vload16(0, at), fma((float16)(share[1][i]), vload16(0, at + line_floats), sum));
          }
          rc_store16(sum, 0, row + slot);
        }
      }
  }
  for (uint line = 0; line < RC_LASER_LINES; ++line) {
    for (uint kind = 0; kind < 2u; ++kind)
      for (uint pixel = 0; pixel < RC_OWN_PIXELS; ++pixel) rc_close_row(t, own + (kind * own_rows + pixel * RC_LASER_LINES + line) * row_floats, total[line]);
    for (uint i = 0; i < RC_SUM_COUNT; ++i) {
      const size_t at = ((size_t)owner * RC_LASER_LINES + line) * RC_SUM_COUNT + i;
      sums[2u * at] = total[line][i][0];
      sums[2u * at + 1u] = total[line][i][1];
    }
  }
}

kernel void lidar_air(LIDAR_AIR_PARAMETERS) {
  lidar_air_body((uint)get_group_id(0), shots, samples, exits, photons, node_weight, first_node, air, backscatter, volumes, volume_values, volume_depth, taps,
                 settings, stopped, rows, scratch, sums, bins, taps_used, first_tap, phases);
}
