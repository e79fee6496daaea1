// The verb `raycube atmos export`: a render table as CSV, for other programs.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_atmos_export();

}  // namespace raycube::cli
