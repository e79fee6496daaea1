/* Reads: records of beams that differ, one for each way that start and end may lie to one another; sub-rays. Writes: a
 * table of each beam and pixel, of what the beam's width and the field stop let through from a distance. Next:
 * lidar_air. */
#include "kernels/lidar/context.h"
#include "kernels/lidar/tables.h"
#include "kernels/lidar/beam.h"

RC_BODY lidar_beam_body(uint index, RC_PARAMETERS(RC_LIDAR_BEAM_ARGUMENTS)) {
  LidarTables all = {.shot = beams + (size_t)index * RC_SHOT_FLOAT4S,
                     .samples = samples,
                     .exits = exits,
                     .settings = settings,
                     .bins = bins};
  rc_read_plan(plan, &all);
  const LidarTables* t = &all;
  const Beam beam = rc_beam(t);
  const float way = settings[RC_SET_GATE_WAY], step = 1.0f / settings[RC_SET_BINS_PER_M];
  const float16 reach = rc_beam_distance(&beam, (float16)(fmax(fma((float)(bins + t->padded_taps), step, way), 0.0f)));
  const float16 begin = rc_beam_distance(&beam, (float16)(fmax(fma((float)-t->padded_taps, step, way), 0.0f)));
  const float far = fmax(reach.s0, 1e-3f),
              near = fmax(fmax(begin.s0, 1e-6f * far), fmin(settings[RC_SET_MINIMUM_RANGE], far));
  const float log_near = log(near), log_span = fmax(log(far) - log_near, 1e-6f);
  const uint posts = (uint)clamp(100.0f * log_span + 2.0f, 4.0f, (float)RC_POSTS);
  const float per_log = (float)(posts - 1u) / log_span;
  for (uint pixel = 0; pixel < RC_OWN_PIXELS(t); ++pixel) {
    global float* table = tables + ((size_t)index * RC_OWN_PIXELS(t) + pixel) * RC_BEAM_FLOATS;
    for (uint i = 0; i < posts; ++i)
      table[i] = rc_beam_sum(t, &beam, exp(fma((float)i, 1.0f / per_log, log_near)), (float)pixel);
    table[posts] = table[posts - 1u];
    table[RC_BEAM_LOG_NEAR] = log_near;
    table[RC_BEAM_POSTS_PER_LOG] = per_log;
    table[RC_BEAM_LAST] = (float)(posts - 1u);
  }
}

kernel void lidar_beam(RC_PARAMETERS(RC_LIDAR_BEAM_ARGUMENTS)) {
  lidar_beam_body((uint)get_global_id(0), RC_PASSED(RC_LIDAR_BEAM_ARGUMENTS));
}
