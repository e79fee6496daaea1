// What no pixel should exceed: a guard against faults of tables and plans, which show as light from nowhere.
#pragma once

#include <vector>

#include "atmos_tables/render_table.h"
#include "host/plan/plan.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::plan {

/// Band means of E0 / (pi (1 - S)) + max(B(T), L_sky) + L_path, W m-2 sr-1 um-1: a white Lambertian surface
/// that faces the sun above the air, over white ground whose light the air sends back down (S its spherical
/// albedo, 0 where the plan has no light between ground and air), the hottest used material as a black body or
/// the warmest sky it mirrors, and the brightest path of the plan. Sun and emission are 0 where they are off. A
/// Lambertian scene stays below, as the air takes from the beam at least what it adds as skylight.
std::vector<double> radiance_limit(const Plan& plan, const scene::CompiledScene& scene,
                                   const atmos::RenderTable& table);

}  // namespace raycube::plan
