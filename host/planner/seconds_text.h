// Seconds in words for people: two figures, and never an exponent.
#pragma once

#include <string>

#include <fmt/format.h>

namespace raycube::planner {

inline std::string seconds_text(double seconds) {
  if (seconds >= 10) return fmt::format("{:.0f}", seconds);
  if (seconds >= 1) return fmt::format("{:.1f}", seconds);
  return seconds >= 0.005 ? fmt::format("{:.2f}", seconds) : "less than 0.01";
}

}  // namespace raycube::planner
