#include "atmos_tables/aerosol/height_profile.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "atmos_tables/optics/air_profile.h"
#include "host/base/error.h"

namespace raycube::atmos {

HeightProfile::HeightProfile(std::vector<Knot> knots) : knots_(std::move(knots)) {
  for (std::size_t i = 0; i < knots_.size(); ++i)
    if (!(knots_[i].extinction_per_km >= 0) || (i > 0 && !(knots_[i].height_km > knots_[i - 1].height_km)))
      throw base::Error(base::Fault::bug, "aerosol profile: knots must ascend, extinctions must not be negative");
}

double HeightProfile::extinction_per_km(double height_km) const {
  for (std::size_t i = 1; i < knots_.size(); ++i) {
    const Knot &low = knots_[i - 1], &high = knots_[i];
    if (height_km >= low.height_km && height_km <= high.height_km)
      return between(low.extinction_per_km, high.extinction_per_km,
                     (height_km - low.height_km) / (high.height_km - low.height_km));
  }
  return 0;
}

double HeightProfile::depth(double low_km, double high_km) const {
  double out = 0;
  for (std::size_t i = 1; i < knots_.size(); ++i) {
    const Knot &low = knots_[i - 1], &high = knots_[i];
    const double from = std::max(low_km, low.height_km), to = std::min(high_km, high.height_km);
    if (to <= from) continue;
    const auto at = [&](double height) {
      return between(low.extinction_per_km, high.extinction_per_km,
                     (height - low.height_km) / (high.height_km - low.height_km));
    };
    // A part of a linear piece stays linear although neither of its ends need be 0.
    const bool linear = low.extinction_per_km == 0 || high.extinction_per_km == 0;
    out += (to - from) * (linear ? (at(from) + at(to)) / 2 : mean_between(at(from), at(to)));
  }
  return out;
}

double HeightProfile::total_depth() const {
  return knots_.empty() ? 0 : depth(knots_.front().height_km, knots_.back().height_km);
}

void HeightProfile::scale(double factor) {
  for (Knot& knot : knots_) knot.extinction_per_km *= factor;
}

}  // namespace raycube::atmos
