/* What the steps of paths were, for the reference to replay (host/reference/path_replay.h): the rays that were sent,
 * what they met, what was decided there. Nothing is handed over but to a probe that asks for it
 * (PathTables::log_paths). */
#ifndef RAYCUBE_KERNELS_LIGHT_PATH_LOG_H
#define RAYCUBE_KERNELS_LIGHT_PATH_LOG_H

#include "kernels/light/path_matter.h"

/* Step `step` of path `path` of a pixel of the group. */
static inline global PathStep* rc_step(const PathTables* t, uint pixel, uint path, uint step) {
  return t->log + ((size_t)pixel * t->log_paths + path) * (t->levels + 1u) + step;
}
static inline global PathStep* rc_step_of(const PathTables* t, const Paths16* paths, uint k, uint step) {
  return rc_step(t, paths->pixel[k], paths->path[k], step);
}

static inline void rc_log_ray(global PathStep* to, const Rays16* rays, uint k, float weight, float scale) {
  to->start = (float4)(rays->x[k], rays->y[k], rays->z[k], weight);
  to->way = (float4)(rays->dx[k], rays->dy[k], rays->dz[k], scale);
  to->instance = to->primitive = RC_NONE;
  to->slot = 0u;
  to->decided = RC_STEP_SENT;
}

static inline void rc_log_met(global PathStep* to, const Ends16* ends, uint k) {
  to->instance = ends->instance[k], to->primitive = ends->primitive[k];
  to->decided |= ends->instance[k] == RC_NONE ? 0u : RC_STEP_MET;
}

/* What was decided at the ends of the live paths: those of `on` go on, and their next rays are known. */
static inline void rc_log_ends(const PathTables* t, uint live, uint on, uint level, const Ends16* ends,
                               const Paths16* paths) {
  for (; live; live &= live - 1u) {
    const uint k = rc_lowest(live);
    global PathStep* at = rc_step_of(t, paths, k, level - 1u);
    at->decided |= ends->lit >> k & 1u ? RC_STEP_LIT : 0u;
    at->decided |= (on >> k & 1u ? paths->went[k] : RC_STEP_ENDS) << RC_STEP_SIDE;
    if (on >> k & 1u) rc_log_ray(rc_step_of(t, paths, k, level), &paths->rays, k, 0.0f, 0.0f);
  }
}

#endif
