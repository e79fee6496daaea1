// How much of the open sky each surface of a scene sees, from a few of its pixels: what the sky's rays may take for
// granted, and how many directions meet other surfaces (plan::SkyRays).
#pragma once

#include "host/plan/plan.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Fills plan.sky.open_share and plan.sky.met; without a sky nothing is rendered. The plan stays free of bias whatever
/// is found. Rays are weighed by the first component's light; what is below a surface's horizon counts as met.
void measure_open_share(render::Renderer& renderer, const scene::Simulation& simulation,
                        const scene::Instrument& instrument, plan::Plan& plan);

/// The instrument as it is first launched: with the samples of the image where they are known, with those of the
/// planner's look where a trial has to find them.
scene::Instrument first_launched(const scene::Simulation& simulation, const scene::Instrument& instrument,
                                 const plan::Plan& plan);

}  // namespace raycube::planner
