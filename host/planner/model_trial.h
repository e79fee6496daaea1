// What a plan's nodes and sky components are off by on the scene's own pixels: the plan against the whole tables, both in double on the
// same rays by Embree. Worst-case estimates (plan_errors.h) take the worst obstacle and the worst place; pixels see less than that.
#pragma once

#include "atmos_tables/render_table.h"
#include "host/plan/plan.h"
#include "host/planner/trial_pixels.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Errors of the whole and of its parts, each of its own worst band over the band's mean radiance.
struct ModelError {
  TrialError total, sun, sky, path, environment, emission;
  std::size_t pixels = 0;
};

/// Over hashed pixels (all of a small image), a few samples of each. Both sides look at the sky in the same directions and count what they
/// see alike, so that their number is no part of it. Light of what hides the sky is left out: its one temperature is no level of the plan
/// (`raycube check` reports its error). `threads`: 0 all; the result does not depend on it.
ModelError model_error(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan, const atmos::RenderTable& table,
                       int threads = 0);

}  // namespace raycube::planner
