// The verb `raycube atmos lidar`: profiles of extinction and backscatter at laser wavelengths.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_atmos_lidar();

}  // namespace raycube::cli
