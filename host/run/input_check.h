// What a simulation's inputs alone say is wrong, all of it, before a ray is sent or a table of air computed that
// takes long (a LIDAR's profiles take a tenth of a second: they are made).
#pragma once

#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Throws one Error(input) that lists every problem of these instruments and LIDARs that needs no ray and no
/// model of the air to be known: views, point spreads and bands; used materials' curves that do not cover
/// them, and temperatures that thermal light needs; bands, sun, sensor, heights and views beyond the
/// atmosphere's table or its model's range; light between ground and air that the table has no rows for.
/// `scene check`, and what begins a render, a check, a plan, a chart and a tuning. Returns what is not refused
/// but to be known of instruments under a table that needs no computing, as a render says it later.
/// `background`: with what the light of the scene in LIDARs' fields of view asks for, which renders alone compute;
/// plans of renders ask, too.
std::vector<std::string> check_inputs(const scene::Simulation& simulation,
                                      const std::vector<const scene::Instrument*>& instruments,
                                      const std::vector<const scene::Lidar*>& lidars, bool background = false);
/// The same for all instruments and LIDARs of the file, with background; and what planning refuses where the table of
/// the air is known: a tolerance that no plan holds, levels of [plan] that none can have.
std::vector<std::string> check_inputs(const scene::Simulation& simulation);

}  // namespace raycube::run
