// What was built: written by the build into version.cpp.
#pragma once

namespace raycube::base {

extern const char* const kVersion;   ///< "0.1.0"
extern const char* const kCommit;    ///< git describe of the source, "unknown" outside a repository
extern const char* const kCompiler;  ///< "GNU 12.2.0, Release"

}  // namespace raycube::base
