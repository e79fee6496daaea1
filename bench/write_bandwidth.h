// The roof that spectral integration is measured against: plain 16-wide stores.
#pragma once

#include <cstddef>

namespace raycube::bench {

/// Fills `count` floats (a multiple of 16, 64-byte aligned) with 16-wide plain stores, each thread its own part.
void fill16(float* buffer, std::size_t count, float value, int threads);

}  // namespace raycube::bench
