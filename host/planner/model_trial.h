// What a plan's nodes and sky components are off by on the scene's own pixels: the plan against the whole tables, both
// in double on the same rays by Embree. Worst-case estimates (plan_errors.h) take the worst obstacle and the worst
// place; pixels see less than that.
#pragma once

#include "atmos_tables/render_table.h"
#include "host/plan/plan.h"
#include "host/planner/trial_pixels.h"
#include "host/reference/radiance.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Pixels by the plan and by the whole tables, in the order of the tiles.
struct ModelPixels {
  std::vector<reference::BandRadiance> planned, whole;
  std::vector<float> weight;  ///< of each in the figure that the tolerance is of; empty: all alike
};

/// How they are compared: `side` x `side` jittered samples of a pixel under `directions`, turned by `turn_rad` about
/// the zenith. Both sides look at the sky in the same directions and count what they see alike, so that their number is
/// no part of the difference but for a sky that is steep: what the components leave out sums to no light over all
/// directions, over a few to a remainder (sun at 88.5 degrees over a plane: 1.1 % over 256, 0.6 % over 1024, 0.4 % over
/// 4096).
struct ModelSettings {
  int side = 2, directions = 256;
  double turn_rad = 0;
  std::uint64_t seed = 0;
  int threads = 0;  ///< 0: all; no result depends on it
};

ModelPixels compare_models(const scene::Simulation& simulation, const scene::Instrument& instrument,
                           const plan::Plan& plan, const atmos::RenderTable& table,
                           const std::vector<render::Tile>& tiles, const ModelSettings& settings);

/// Errors of the whole and of its parts, each of its own worst band over the band's mean radiance.
struct ModelError {
  TrialError total, sun, sky, path, environment, emission;
  std::size_t pixels = 0;
};

/// Over two of the eight pixels of each of at most 64 hashed runs, a few samples of each. Light of what hides the sky
/// is left out: its one temperature is no level of the plan (`raycube check` reports its error).
ModelError model_error(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan,
                       const atmos::RenderTable& table, int threads = 0, int directions = ModelSettings{}.directions);

}  // namespace raycube::planner
