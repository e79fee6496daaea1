// Random numbers of the scene: a function of (seed, stream, index, dimension), never of the order of calls.
#pragma once

#include <cstdint>

namespace raycube::scene {

/// Finaliser of SplitMix64 (Steele, Lea & Flood 2014, OOPSLA, "Fast splittable pseudorandom number
/// generators").
constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

/// Uniform in [0, 1), 53 bits.
constexpr double counter_uniform(std::uint64_t seed, std::uint64_t stream, std::uint64_t index,
                                 std::uint64_t dimension) {
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15ull;
  std::uint64_t z = mix64(seed + golden);
  z = mix64(z + stream * golden + 1);
  z = mix64(z + index * golden + 2);
  z = mix64(z + dimension * golden + 3);
  return static_cast<double>(z >> 11) * 0x1p-53;
}

}  // namespace raycube::scene
