// What `raycube info` says about a picture: OpenEXR, PNG, JPEG, TIFF.
#pragma once

#include <string>

#include "host/cli/verb.h"

namespace raycube::cli {

void print_picture_info(Invocation& invocation, const std::string& path, bool header_only);

}  // namespace raycube::cli
