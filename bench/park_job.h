// The park and what render would make of it: the same loader, table and plan.
#pragma once

#include "bench/cases.h"
#include "host/run/camera_job.h"

namespace raycube::bench {

/// Throws Error(environment) with the command that makes the park when it is not there.
scene::Simulation load_park(const Settings& settings);

/// Table and plan of one instrument, by the verbs' own function.
run::CameraJob prepare_job(const scene::Simulation& simulation, const scene::Instrument& instrument);

/// One word of a shell command.
std::string shell_quoted(const std::string& text);

}  // namespace raycube::bench
