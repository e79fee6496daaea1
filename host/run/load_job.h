// What every run begins with: a simulation file to a scene, and which of its instruments and LIDARs are wanted.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Loads the file; notices go to the log. `seed`: in place of the file's. Throws Error(input) with every problem found.
/// overrides: KEY=VALUE in place of what the file says.
scene::Simulation load_job(const std::string& file, std::optional<std::uint64_t> seed, Services& services,
                           const std::vector<std::string>& overrides = {});

/// What its user should know of an instrument's light: a sun or moon that is down. load_job logs them.
std::vector<std::string> light_notices(const scene::Simulation& simulation, const scene::Instrument& instrument);
/// The same of a LIDAR's background of sunlight.
std::vector<std::string> light_notices(const scene::Simulation& simulation, const scene::Lidar& lidar);

/// The passive instruments called `name`, or all when it is empty. Throws Error(input) that lists instruments and
/// LIDARs when neither has one of that name.
std::vector<const scene::Instrument*> pick_instruments(const scene::Simulation& simulation, const std::string& name);

/// The LIDARs called `name`, or all when it is empty; none is no error.
std::vector<const scene::Lidar*> pick_lidars(const scene::Simulation& simulation, const std::string& name);

}  // namespace raycube::run
