// What walking the device's own paths again finds (path_replay.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/reference/double_trace.h"

namespace raycube::reference {

struct ReplayReport {
  static constexpr double kMostOff = 2e-5;     ///< of a pixel's sum at any wavelength
  static constexpr double kMostWayOff = 1e-5;  ///< of a direction's components, or of a weight by its own
  std::uint64_t pixels = 0, paths = 0, steps = 0;
  std::array<std::uint64_t, kCauses> hits{};  ///< of the steps' rays, by Cause
  std::uint64_t asked = 0, asked_explained = 0,
                asked_unexplained = 0;  ///< rays that ask whether anything hides a light
  std::uint64_t decisions = 0, decisions_near = 0, decisions_wrong = 0;  ///< near: the draw at the chance, to rounding
  std::uint64_t ways_wrong = 0;                                          ///< directions and weights
  std::uint64_t excluded_pixels = 0;                                     ///< with anything unexplained or wrong
  std::uint64_t other_bits = 0;  ///< tiles that the program which hands over steps renders otherwise
  double worst_way = 0;          ///< over its limit, times kMostWayOff
  double worst = 0;  ///< of the other pixels, of the sum of what the paths bring without regard to its sign
  std::uint32_t worst_line = 0, worst_sample = 0;

  void add(const ReplayReport& other);
  std::vector<std::string> failures() const;
  std::string text() const;  ///< empty where nothing was replayed
};

}  // namespace raycube::reference
