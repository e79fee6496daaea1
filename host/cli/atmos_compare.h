// The verb `raycube atmos compare`: band-wise differences of two render tables.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_atmos_compare();

}  // namespace raycube::cli
