#include "host/render/adaptive.h"

#include <algorithm>
#include <cmath>

#include "host/render/truth.h"

namespace raycube::render {

namespace {

/// Shares nearer than this are equal: sums of float weights.
constexpr float kSame = 1e-5f;

/// All of the pixel's samples do or none does, and so do those of another.
bool whole_and_same(float share, float other) {
  return std::abs(share - other) < kSame && (share < kSame || share > 1 - kSame);
}

}  // namespace

std::vector<std::uint8_t> unsettled(const FirstLook& look, double tolerance) {
  const auto columns = static_cast<std::size_t>(look.columns);
  std::vector<std::uint8_t> open(look.error.size(), 0);
  for (int line = 0; line < look.lines; ++line)
    for (int column = 0; column < look.columns; ++column) {
      const std::size_t at = static_cast<std::size_t>(line) * columns + static_cast<std::size_t>(column);
      const float* here = look.truth.data() + at * look.layers;
      double square = 0;
      int pixels = 0;
      bool even = true;
      for (int y = std::max(0, line - 1); y <= std::min(look.lines - 1, line + 1); ++y)
        for (int x = std::max(0, column - 1); x <= std::min(look.columns - 1, column + 1); ++x) {
          const std::size_t there = static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x);
          const float* beside = look.truth.data() + there * look.layers;
          even = even && whole_and_same(here[truth::hit_fraction], beside[truth::hit_fraction]) &&
                 whole_and_same(here[truth::sun_fraction], beside[truth::sun_fraction]);
          square += double{look.error[there]} * double{look.error[there]};
          ++pixels;
        }
      open[at] = !(even && std::sqrt(square / pixels) <= tolerance);  // an error that is not known settles nothing
    }
  return open;
}

}  // namespace raycube::render
