// What `raycube info` says about a LAS file.
#pragma once

#include <string>

#include "host/cli/verb.h"

namespace raycube::cli {

void print_las_info(Invocation& invocation, const std::string& path);

}  // namespace raycube::cli
