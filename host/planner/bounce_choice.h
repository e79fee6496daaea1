// Whether light goes between surfaces, where the file leaves it to the planner.
#pragma once

#include "host/plan/plan.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Where the file asks for `bounces = "auto"`, drops plan.bounces if light scattered once is nearer than a tenth of the
/// tolerance to all light, after plan.sky.met; else paths keep the most surfaces they may have, since few come so far
/// and those that can carry little end by chance. Returns whether it dropped them: the plan's programs are others then.
///
/// Light scattered once misses about rms q / ((1 - q on) s) of what is seen, with q the largest reflectance and
/// transmittance together of any surface and wavelength and s the sine of the sun's elevation, 0.1 at least; light of N
/// surfaces misses (q on)^N of that. What is met is taken to be of that matter and to face the sun, so both are rather
/// too large than too small (docs/light.md says by how much); where surfaces are shaped their bright side adds to what
/// is open. Nothing is dropped where matter is glossy.
///
/// Of plans with thermal light it is measured: 512 pixels are rendered with paths and without, twice.
bool choose_bounces(render::Renderer& renderer, const scene::Simulation& simulation,
                    const scene::Instrument& instrument, plan::Plan& plan);

}  // namespace raycube::planner
