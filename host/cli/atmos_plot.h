// The verb `raycube atmos plot`: draws a render table.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_atmos_plot();

}  // namespace raycube::cli
