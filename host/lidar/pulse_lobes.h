// How surfaces spread pulses: the lobes of matter, each by its share of a laser's line.
#pragma once

#include <vector>

#include "host/lidar/lidar_plan.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::lidar {

/// What a line's pulses ask of a material; of matter whose lobes have curves of their own their factors too.
Matter matter_at(const LidarPlan& plan, const scene::Material& material, std::size_t line);

/// 1/sr: what a surface reflects of a line, per unit of its reflectance.
double front_form(const LidarPlan& plan, const scene::CompiledScene& scene, std::uint32_t surface, int line,
                  const RcAngles& angles);
/// 1/sr: what it mirrors by its materials' gloss.
double gloss_form(const LidarPlan& plan, const scene::CompiledScene& scene, std::uint32_t surface, int line,
                  const RcAngles& angles);

/// alpha of the facets by which paths look for light that a surface's gloss sends on: the roughest of its lobes.
double gloss_alpha(const scene::CompiledScene& scene, std::uint32_t surface);

/// Whether lines have shares of lobes of their own.
bool has_line_lobes(const scene::CompiledScene& scene);

/// scene::surface_lobes with each line's shares: [surface][lines, where has_line_lobes, else 1][record].
std::vector<shared::Lobe> pulse_lobes(const LidarPlan& plan, const scene::CompiledScene& scene);

}  // namespace raycube::lidar
