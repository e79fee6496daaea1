// Differences as tests state them.
#pragma once

#include <cmath>

namespace raycube::test {

/// |value - truth| over |truth|.
inline double relative(double value, double truth) { return std::abs(value - truth) / std::abs(truth); }

}  // namespace raycube::test
