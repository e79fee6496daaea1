// What the program asks Python for: charts and LAZ, by scripts of host/plots.
#pragma once

#include <string>
#include <vector>

namespace raycube::run {

/// The system's, which Debian's packages add to.
inline constexpr const char* kSystemPython = "/usr/bin/python3";

/// Runs `python` (a path, or a name that PATH holds) with these arguments; its stderr is ours. Whether it ended well.
/// Throws Error(environment) where it could not be started (`needed`: what for, and what gives it), Error(interrupted)
/// after Ctrl-C.
bool run_python(const std::string& python, const std::vector<std::string>& arguments, const std::string& needed);

/// Of host/plots, as installed.
std::string script_path(const std::string& script);

}  // namespace raycube::run
