// Wall and processor time, for reports.
#pragma once

#include <chrono>
#include <ctime>

namespace raycube::base {

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Of all threads of this process since it began. Never what a choice is made by.
inline double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace raycube::base
