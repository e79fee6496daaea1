#include "atmos_tables/optics/size_distribution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "host/base/error.h"

namespace raycube::atmos {

SizeDistribution SizeDistribution::lognormal(const std::vector<LogNormalMode>& modes) {
  base::Problems problems;
  if (modes.empty()) problems.add({"", 0, 0, "size distribution"}, "needs a mode", "none", "give at least one mode");
  double total = 0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const LogNormalMode& mode = modes[i];
    const base::Where where{"", 0, 0, "size distribution, mode " + std::to_string(i + 1)};
    if (!(mode.share > 0 && std::isfinite(mode.share)))
      problems.add(where, "the share must be positive", std::to_string(mode.share), "drop an empty mode");
    if (!(mode.median_radius_um >= 1e-5 && mode.median_radius_um <= 1e4))
      problems.add(where, "the median radius must lie in 1e-5 to 1e4 um", std::to_string(mode.median_radius_um),
                   "give it in um");
    if (!(mode.geometric_sigma >= 1.01 && mode.geometric_sigma <= 10))
      problems.add(where, "the geometric standard deviation must lie in 1.01 to 10",
                   std::to_string(mode.geometric_sigma), "give the factor s itself, not its logarithm");
    total += mode.share;
  }
  problems.throw_if_any();

  struct Bell {
    double height, center, width;
  };
  std::vector<Bell> bells;
  SizeDistribution out;
  for (const LogNormalMode& mode : modes) {
    const double width = std::log(mode.geometric_sigma), center = std::log(mode.median_radius_um);
    bells.push_back({mode.share / total / (std::sqrt(2 * std::numbers::pi) * width), center, width});
    // Weighted with r^6 the bell's centre moves up by 6 width^2; 9 widths beyond: 1e-18 of the moment.
    const double first = center - 9 * width, last = center + 6 * width * width + 9 * width;
    out.first_ = bells.size() == 1 ? first : std::min(out.first_, first);
    out.last_ = bells.size() == 1 ? last : std::max(out.last_, last);
  }
  out.density_ = [bells](double log_radius) {
    double sum = 0;
    for (const Bell& bell : bells) {
      const double t = (log_radius - bell.center) / bell.width;
      sum += bell.height * std::exp(-0.5 * t * t);
    }
    return sum;
  };
  return out;
}

SizeDistribution SizeDistribution::modified_gamma(double alpha, double b, double gamma) {
  base::Problems problems;
  for (double value : {alpha, b, gamma})
    if (!(value > 0 && std::isfinite(value)))
      problems.add({"", 0, 0, "modified gamma distribution"}, "alpha, b and gamma must be positive",
                   std::to_string(value), "correct it");
  problems.throw_if_any();
  // int r^alpha exp(-b r^gamma) dr = Gamma((alpha + 1)/gamma) / (gamma b^((alpha + 1)/gamma)).
  const double power = (alpha + 1) / gamma, log_norm = std::log(gamma) + power * std::log(b) - std::lgamma(power);
  const double log_mode = std::log(alpha / (b * gamma)) / gamma;  // of n(r)
  SizeDistribution out;
  out.density_ = [=](double u) { return std::exp(log_norm + (alpha + 1) * u - b * std::exp(gamma * u)); };
  out.first_ = log_mode - 45 / (alpha + 1);  // falls as r^(alpha + 1)
  // Beyond the mode of r^6 n(r): where b r^gamma has grown by 45 plus what the powers add.
  out.last_ = std::log((alpha + 8) / (b * gamma)) / gamma;
  while (b * std::exp(gamma * out.last_) - (alpha + 8) * (out.last_ - log_mode) < 60) out.last_ += 0.05;
  return out;
}

}  // namespace raycube::atmos
