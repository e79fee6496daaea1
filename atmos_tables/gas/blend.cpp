#include "atmos_tables/gas/blend.h"

#include <algorithm>

namespace raycube::atmos {

namespace {

/// From this wavenumber up to the next: 4.0, 3.4, 3.0, 2.4, 2.0, 1.75, 1.3, 1.0, 0.58 um.
struct Band {
  double from_per_cm, q;
};
constexpr double kHalfRamp = 25;
/// The outer ramps lie inside 2500 to 17250 cm-1.
constexpr Band kBands[] = {{2500 + kHalfRamp, 0.5}, {1e4 / 3.4, 0.25}, {1e4 / 3.0, 0.5},
                           {1e4 / 2.4, 1.0},        {1e4 / 2.0, 0.6},  {1e4 / 1.75, 0.4},
                           {1e4 / 1.3, 0.65},       {1e4 / 1.0, 0.75}, {17250 - kHalfRamp, 0.0}};

}  // namespace

double blend_weight(double wavenumber_per_cm) {
  double q = 0, before = 0;
  for (const Band& band : kBands) {
    q += (band.q - before) * std::clamp((wavenumber_per_cm - band.from_per_cm + kHalfRamp) / (2 * kHalfRamp), 0.0, 1.0);
    before = band.q;
  }
  return q;
}

}  // namespace raycube::atmos
