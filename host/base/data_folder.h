// Where the program's own data lies: plots/, scenes/ and kernels/. Found relative to the executable, so an installation
// can be moved.
#pragma once

#include <filesystem>

namespace raycube::base {

/// The folder named by RAYCUBE_DATA; else ../share/raycube beside the executable's folder (installed); else
/// share/raycube in the executable's folder (build tree). Throws Error(environment) when none is there.
std::filesystem::path data_folder();

}  // namespace raycube::base
