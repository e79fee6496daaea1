// The way in: a simulation file to a validated Simulation with its compiled scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::scene {

struct LoadOptions {
  std::optional<std::uint64_t> seed = {};  ///< instead of the file's
  bool compile = true;                     ///< false: validate only, Simulation::scene stays empty
  bool need_instruments = false;           ///< a file without [[instrument]] and [[lidar]] is an error
  TreeSharing trees = TreeSharing::together;
  /// Instead of the file's [atmosphere] model ("layered", "clear_sky"); empty: the file's. What the file says
  /// of air that both models have goes over to it; a key of the other model alone is a problem.
  std::string air_model = {};
  std::vector<std::string> overrides = {};  ///< KEY=VALUE in place of what the file says (document_overrides.h)
};

/// Reads a file, its includes and all it names. Throws one Error(input) that lists every problem found, each
/// with its place, the value and the way out.
Simulation load_simulation(const std::string& file, const LoadOptions& options = {});

/// Atmospheric pressure at a height above sea level, US Standard Atmosphere 1976 below 11 km: 1013.25 hPa at
/// 0 m, 898.75 hPa at 1000 m.
double standard_pressure_hPa(double height_m);

}  // namespace raycube::scene
