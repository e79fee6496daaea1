// Figures and names as reports of cameras and LIDARs write them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

#include "host/reference/compare.h"

namespace raycube::reference {

/// Three significant digits.
inline std::string three_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Rays by cause: " agree 12, exact tie 0, ...".
inline std::string counts_text(const std::array<std::uint64_t, kCauses>& rays) {
  std::string out;
  for (std::size_t c = 0; c < kCauses; ++c)
    out += std::string(c ? ", " : " ") + cause_name(static_cast<Cause>(c)) + " " + std::to_string(rays[c]);
  return out;
}

/// A cause's name as a key of JSON.
inline std::string key_of(Cause cause) {
  std::string key = cause_name(cause);
  std::replace(key.begin(), key.end(), ' ', '_');
  return key;
}

}  // namespace raycube::reference
