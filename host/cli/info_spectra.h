// What `raycube info` says about a file of measured spectra that is no ENVI library.
#pragma once

#include <string>

#include "host/cli/verb.h"

namespace raycube::cli {

/// By the name's end, and no ENVI image, which has a header beside it.
bool is_spectrum_file(const std::string& path);
void print_spectra_info(Invocation& invocation, const std::string& path);

}  // namespace raycube::cli
