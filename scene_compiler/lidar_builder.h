// [[lidar]] entries: platform, pulse, optics, gate and detection, checked and in SI units.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/placed_box.h"
#include "scene_compiler/scene_builder.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Every LIDAR, checked; heights above ground come from the terrains of `parts` (0 off them). Problems are
/// collected. `box` is around all that is placed. `has_sun`: the file says where the sun is, so background
/// light can be had.
std::vector<Lidar> read_lidars(const Record& root, const SceneParts& parts, const PlacedBox& box, bool has_sun,
                               std::vector<std::string>& notices, base::Problems& problems);

/// Half width at 1/e2 of a Gaussian over the half width that `definition` names: 1 ("1/e^2"), sqrt 2 ("1/e"), sqrt(2 /
/// ln 2) ("FWHM"), 2 ("1 sigma"); edge: 1, of a uniform beam. nullopt: no such definition. (LIDAR specification, 2.1.)
std::optional<double> beam_width_factor(const std::string& definition);

/// Half angle of the simulation (1/e2 of a gaussian, edge of a uniform beam) of an angle given as "full angle FWHM" and
/// so on; same unit as `angle`. nullopt: no such definition.
std::optional<double> half_divergence(double angle, const std::string& definition);

}  // namespace raycube::scene
