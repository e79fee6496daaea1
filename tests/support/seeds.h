// Seeds that tests/repeat_seeds.py can change: how far a test of chance is from its limits is told by other draws.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace raycube::testing {

/// A test's own seed; with RAYCUBE_TEST_SEED = 1, 2, .. another one, so far off that tests that count seeds up from
/// theirs share none.
inline std::uint64_t seed(std::uint64_t own) {
  static const char* const other = std::getenv("RAYCUBE_TEST_SEED");
  return other ? own + 1000003 * std::strtoull(other, nullptr, 10) : own;
}
inline std::uint32_t seed32(std::uint32_t own) { return static_cast<std::uint32_t>(seed(own)); }

}  // namespace raycube::testing
