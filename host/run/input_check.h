// What a simulation's inputs alone say is wrong, all of it, before a ray is sent or a table of air computed that
// takes long (a LIDAR's profiles take a tenth of a second: they are made).
#pragma once

#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::run {

/// What of a simulation a verb is going to compute.
struct Asked {
  std::vector<const scene::Instrument*> instruments{};
  std::vector<const scene::Lidar*> lidars{};
  /// With what the light of the scene in LIDARs' fields of view asks for, which renders alone compute; plans of renders
  /// ask, too.
  bool background = false;
  std::vector<const scene::Measure*> measures{};
  std::vector<const scene::LightBudget*> budgets{};
};

/// Throws one Error(input) that lists every problem of what is asked for that needs no ray and no model of the air to
/// be known: views, point spreads and bands; used materials' curves that do not cover them, and temperatures that
/// thermal light needs; bands, sun, sensor, heights and views beyond the atmosphere's table or its model's range; light
/// between ground and air that the table has no rows for; nodes of [plan] that no plan can have; of measures and
/// budgets the sun, the bands and the scene's edge.
/// `scene check`, and what begins a render, a check, a plan, a chart, a tuning and a measure. Returns what is not
/// refused but to be known of instruments under a table that needs no computing, as a render says it later.
std::vector<std::string> check_inputs(const scene::Simulation& simulation, const Asked& asked);
/// The same for all that the file holds, with background; and what planning refuses where the table of the air is known
/// (run::quick_table): a tolerance that no plan holds, levels of [plan] that none can have. Where it is not, what is
/// returned says of tight tolerances that planning will judge them.
std::vector<std::string> check_inputs(const scene::Simulation& simulation);

}  // namespace raycube::run
