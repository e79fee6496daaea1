// raycube lidar gff: overlap of beam and receiver against range.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_lidar_gff();

}  // namespace raycube::cli
