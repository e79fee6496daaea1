// The verb `raycube atmos import`: reads another code's output and says what it holds.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_atmos_import();

}  // namespace raycube::cli
