#include "atmos_tables/air_column.h"

#include <algorithm>
#include <cmath>

#include "host/base/units.h"

namespace raycube::atmos {

AirColumn::AirColumn(std::vector<double> heights_m, double ground_height_m) {
  for (double km :
       {0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 13.0, 17.0, 21.0, 25.0, 30.0, 40.0, 60.0})
    heights_m.push_back(1000 * km);
  heights_m.push_back(kTopOfAir_m);
  const double lowest = *std::min_element(heights_m.begin(), heights_m.end());
  for (double height : heights_m)
    if (height >= lowest && height <= kTopOfAir_m) levels_.push_back(height);
  std::sort(levels_.begin(), levels_.end());
  levels_.erase(std::unique(levels_.begin(), levels_.end()), levels_.end());

  const auto ozone = [](double height_m) { return (1 + std::exp(-4.0)) / (1 + std::exp((height_m / 1000 - 20) / 5)); };
  const double ozone_here = ozone(ground_height_m);
  const auto above = [&](double h) {
    return ColumnShare{std::exp(-h / kAirScaleHeight_m), std::exp(-h / kAerosolScaleHeight_m),
                       std::exp(-h / kWaterScaleHeight_m), ozone(ground_height_m + h) / ozone_here};
  };
  for (std::size_t i = 0; i + 1 < levels_.size(); ++i) {
    const bool last = i + 2 == levels_.size();
    shares_.push_back(above(levels_[i]) + (last ? 0.0 : -1.0) * above(levels_[i + 1]));
  }
}

std::size_t AirColumn::level_of(double height_m) const {
  const double height = std::min(height_m, kTopOfAir_m);
  const auto found = std::lower_bound(levels_.begin(), levels_.end(), height);
  return std::min<std::size_t>(static_cast<std::size_t>(found - levels_.begin()), levels_.size() - 1);
}

std::vector<double> AirColumn::slant(std::size_t from, double zenith_deg) const {
  const double theta = base::rad_by_division(zenith_deg);
  const double cosine = std::cos(theta), radius = kEarthRadius_m + levels_[from];
  // Distance along the line to the shell dh above its start: the root of s^2 + 2 r cos s = (2 r + dh) dh, no
  // cancellation.
  const auto distance = [&](double dh) {
    const double square = (2 * radius + dh) * dh;
    return square / (radius * cosine + std::sqrt(radius * radius * cosine * cosine + square));
  };
  std::vector<double> out(layers(), 0.0);
  for (std::size_t i = from; i < layers(); ++i) {
    const double low = levels_[i] - levels_[from], high = levels_[i + 1] - levels_[from];
    out[i] = (distance(high) - distance(low)) / (high - low);
  }
  return out;
}

}  // namespace raycube::atmos
