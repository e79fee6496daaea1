// Kernel sources embedded at build time, includes resolved, with #line directives that name the real files.
#pragma once

#include <string_view>
#include <vector>

namespace raycube::kernels {

/// Source of kernels/entry/<name>.cl. Sources can be joined into one program: every header carries its own guard.
/// Throws Error(bug) for an unknown name.
std::string_view kernel_source(std::string_view name);

/// All entry names, in the order of kernels/CMakeLists.txt.
std::vector<std::string_view> kernel_names();

}  // namespace raycube::kernels
