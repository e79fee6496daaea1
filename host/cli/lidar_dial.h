// raycube lidar dial: gas columns from the waveforms of a run.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_lidar_dial();

}  // namespace raycube::cli
