// Renderers of a test come one after the other, each with a context of its own: whoever includes this builds a program
// once, and not for each of them.
#pragma once

#include "host/cl/context.h"

namespace raycube::test {

inline constexpr std::size_t kKeptPrograms = 64;
inline const bool programs_are_kept = (cl::Context::keep_programs(kKeptPrograms), true);

}  // namespace raycube::test
