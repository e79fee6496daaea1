// Alternating pairs: this machine's speed changes by 2x within minutes, so only ratios taken back to back mean
// anything.
#pragma once

#include <chrono>
#include <vector>

#include "bench/report.h"

namespace raycube::bench {

template <typename Function>
double seconds_of(Function&& run) {
  const auto begin = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Times of two programs doing the same work, run in turn.
struct Pairs {
  std::vector<double> reference_s, ours_s;
  Spread ratio() const {  ///< reference time / our time, pair by pair: above 1 ours is faster
    std::vector<double> ratios;
    for (std::size_t i = 0; i < ours_s.size(); ++i) ratios.push_back(reference_s[i] / ours_s[i]);
    return spread_of(ratios);
  }
};

inline constexpr int kPairs = 9;

/// One full-size warm-up of each (first launches compile, caches fill), then `pairs` alternating runs.
template <typename Reference, typename Ours>
Pairs alternate(Reference&& reference, Ours&& ours, int pairs = kPairs) {
  reference();
  ours();
  Pairs times;
  for (int i = 0; i < pairs; ++i) {
    times.reference_s.push_back(seconds_of(reference));
    times.ours_s.push_back(seconds_of(ours));
  }
  return times;
}

}  // namespace raycube::bench
