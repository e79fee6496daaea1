// Whether a test runs all of its cases or those of its short form.
#pragma once

#include <cstdlib>

namespace raycube::testing {

/// The tests NAME_full, which ci/test --full runs, set RAYCUBE_FULL (raycube_full_test in tests/CMakeLists.txt).
inline bool full() { return std::getenv("RAYCUBE_FULL") != nullptr; }

}  // namespace raycube::testing
