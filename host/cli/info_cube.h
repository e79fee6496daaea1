// What `raycube info` says about an ENVI file.
#pragma once

#include <string>

#include "host/cli/verb.h"

namespace raycube::cli {

/// Prints header and, unless header_only, statistics of the pair that `path` belongs to.
void print_cube_info(Invocation& invocation, const std::string& path, bool header_only, bool every_band);

}  // namespace raycube::cli
