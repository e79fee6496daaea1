// Checks of figures that chance moves, which tests/repeat_seeds.py can read.
#pragma once

#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>
#include <limits>

#include "tests/support/seeds.h"

namespace raycube::testing {

/// Adds a line to the file that RAYCUBE_TEST_FIGURES names: where, what, the figure and between what it passes.
inline void note_figure(const char* file, int line, const char* what, double figure, double low, double high) {
  static const char* const noted = std::getenv("RAYCUBE_TEST_FIGURES");
  if (!noted) return;
  std::ofstream out(noted, std::ios::app);
  out.precision(9);
  out << file << ':' << line << '\t' << what << '\t' << figure << '\t' << low << '\t' << high << '\n';
}

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

}  // namespace raycube::testing

#define CHECK_BETWEEN(figure, low, high)                                              \
  do {                                                                                \
    const double figure_ = static_cast<double>(figure);                               \
    const double low_ = static_cast<double>(low), high_ = static_cast<double>(high);  \
    raycube::testing::note_figure(__FILE__, __LINE__, #figure, figure_, low_, high_); \
    INFO(#figure);                                                                    \
    CHECK(figure_ >= low_);                                                           \
    CHECK(figure_ <= high_);                                                          \
  } while (false)
#define CHECK_BELOW(figure, limit) CHECK_BETWEEN(figure, -raycube::testing::kNoLimit, limit)
#define CHECK_ABOVE(figure, limit) CHECK_BETWEEN(figure, limit, raycube::testing::kNoLimit)
#define CHECK_WITHIN(figure, limit) CHECK_BETWEEN(figure, -(limit), limit)
