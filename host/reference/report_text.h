// Figures and names as reports of cameras and LIDARs write them.
#pragma once

#include <algorithm>
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

/// A cause's name as a key of JSON.
inline std::string key_of(Cause cause) {
  std::string key = cause_name(cause);
  std::replace(key.begin(), key.end(), ' ', '_');
  return key;
}

}  // namespace raycube::reference
