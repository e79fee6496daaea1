#include "host/reference/lidar_pulse.h"

#include <algorithm>
#include <cmath>

namespace raycube::reference {

LidarPulseShape::LidarPulseShape(const scene::LidarPulse& pulse) : shape_(pulse.shape) {
  if (shape_ == scene::PulseShape::tabulated) {
    time_s_ = pulse.shape_time_s, power_ = pulse.shape_power;
    cumulative_.assign(time_s_.size(), 0);
    for (std::size_t i = 1; i < time_s_.size(); ++i)
      cumulative_[i] = cumulative_[i - 1] + 0.5 * (power_[i] + power_[i - 1]) * (time_s_[i] - time_s_[i - 1]);
    const double area = cumulative_.back();
    for (double& value : cumulative_) value /= area;
    for (double& value : power_) value /= area;
    first_s_ = time_s_.front(), last_s_ = time_s_.back();
  } else if (shape_ == scene::PulseShape::rectangular) {
    last_s_ = 0.5 * pulse.fwhm_s, first_s_ = -last_s_;
  } else {
    sigma_s_ = pulse.fwhm_s / (2 * std::sqrt(2 * std::log(2.0)));
    last_s_ = 9 * sigma_s_, first_s_ = -last_s_;
  }
}

double LidarPulseShape::tabulated(double until_s) const {
  if (until_s <= time_s_.front()) return 0;
  if (until_s >= time_s_.back()) return 1;
  const auto i = static_cast<std::size_t>(std::upper_bound(time_s_.begin(), time_s_.end(), until_s) - time_s_.begin());
  const double x = until_s - time_s_[i - 1], slope = (power_[i] - power_[i - 1]) / (time_s_[i] - time_s_[i - 1]);
  return cumulative_[i - 1] + x * (power_[i - 1] + 0.5 * x * slope);
}

double LidarPulseShape::share(double from_s, double to_s) const {
  if (!(to_s > from_s)) return 0;
  if (first_s_ == last_s_) return from_s <= 0 && 0 < to_s ? 1 : 0;
  switch (shape_) {
    case scene::PulseShape::tabulated:
      return tabulated(to_s) - tabulated(from_s);
    case scene::PulseShape::rectangular:
      return std::max(0.0, std::min(to_s, last_s_) - std::max(from_s, first_s_)) / (last_s_ - first_s_);
    case scene::PulseShape::gaussian:
      break;
  }
  const double scale = sigma_s_ * std::sqrt(2.0);
  if (from_s < 0 && to_s > 0) return 0.5 * (std::erf(to_s / scale) - std::erf(from_s / scale));
  if (from_s >= 0) return 0.5 * (std::erfc(from_s / scale) - std::erfc(to_s / scale));
  return 0.5 * (std::erfc(-to_s / scale) - std::erfc(-from_s / scale));
}

}  // namespace raycube::reference
