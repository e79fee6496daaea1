// How much of the open sky each surface of a scene sees, from a few of its pixels: what the sky's rays may take for
// granted (plan::SkyRays).
#pragma once

#include "host/plan/plan.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Fills plan.sky.open_share. Nothing is rendered where it could not matter: without a sky, and where every ray brings
/// the same light, whose noise any share leaves as it is. The plan stays free of bias whatever is found.
void measure_open_share(render::Renderer& renderer, const scene::Simulation& simulation,
                        const scene::Instrument& instrument, plan::Plan& plan);

}  // namespace raycube::planner
