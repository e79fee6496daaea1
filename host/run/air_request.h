// What a table of the layered model is asked for, and the name under which it is kept.
#pragma once

#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::run {

struct AirRequest {
  const scene::AtmosphereSpec* spec = nullptr;
  scene::Sun sun;
  double sensor_height_m = 0;                     ///< above the scene's z = 0
  double first_um = 0, last_um = 0, step_um = 0;  ///< step 0: the model's own grid
  double low_m = 0, high_m = 0;                   ///< of the targets
  bool cached = true;
};

/// SHA-256 over this program and all that the layered table follows from: every field of
/// scene_compiler/air_spec.def (of files what they hold), ground, sun, sensor, wavelengths and heights.
/// Throws Error(environment) when a file cannot be read.
std::string request_hash(const AirRequest& request, const std::vector<double>& wavelength_um,
                         const std::vector<double>& target_height_m);

}  // namespace raycube::run
