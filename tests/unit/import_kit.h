// What the importers' tests share: a fixture written to a file, and the message a reader refuses it with.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "atmos_tables/import/imported.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"
#include "tests/unit/test_folder.h"
#include "tests/support/skipped.h"

namespace raycube::testing {

inline bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// `text` with the first `from` replaced; it must be there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the fixture does not hold \"" + from + "\"");
  return text.replace(at, from.size(), to);
}

/// Folder of the real samples; empty with a loud word when RAYCUBE_SHARED is not set.
inline std::string samples(const std::string& what) {
  const char* shared = std::getenv("RAYCUBE_SHARED");
  if (shared) return std::string(shared) + "/reference/atmosphere/samples/" + what + "/";
  skip_part("the real samples of " + what + " were not read");
  return {};
}

}  // namespace raycube::testing
