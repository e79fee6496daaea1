// Chooses sizes of launches by the clock: every candidate in turn, round after round, so that a machine that slows down
// slows them all.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace raycube::render {

/// Wall seconds of one run with a size, by what is to choose one (a kernel's name, or "tile").
using TimedRun = std::function<std::map<std::string, double>(std::size_t size)>;

struct SizeChoice {
  std::size_t size = 0;
  double seconds = 0;                        ///< median of the rounds with that size
  double preset_seconds = 0;                 ///< the same with the preset
  std::map<std::size_t, double> candidates;  ///< median of each
};

/// A size must be faster than the preset by this part to replace it: less is noise.
inline constexpr double kWorthwhile = 0.05;

/// What takes less with the preset keeps it: too short to time, and not worth another compilation (PoCL: some tenths of
/// a second a kernel and size).
inline constexpr double kLeast_s = 0.05;

/// For everything that `run` times the fastest of the sizes by the median of `rounds` alternating runs, after one round
/// to warm up (compilers, caches) that counts for nothing; the preset, which is one of the sizes, unless it takes
/// kLeast_s and another is faster by kWorthwhile and in every round. What a run with the
/// preset does not time gets no choice. rounds >= 1.
std::map<std::string, SizeChoice> choose_sizes(const std::vector<std::size_t>& sizes, std::size_t preset, int rounds,
                                               const TimedRun& run);

}  // namespace raycube::render
