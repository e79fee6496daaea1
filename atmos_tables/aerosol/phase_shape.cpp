#include "atmos_tables/aerosol/phase_shape.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "atmos_tables/optics/gauss_legendre.h"
#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

constexpr std::size_t kKeptMoments = 256;
constexpr double kRoundingMiss =
    2e-3;  ///< figures with 4 to 5 digits at 34 angles; functions without a peak miss below 1e-3

/// Slopes of the monotone cubic (weighted harmonic means), 0 at both ends.
std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> slope(x.size(), 0);
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    const double d0 = (y[i] - y[i - 1]) / before, d1 = (y[i + 1] - y[i]) / after;
    if (d0 * d1 > 0) slope[i] = 3 * (before + after) / ((2 * after + before) / d0 + (after + 2 * before) / d1);
  }
  return slope;
}

}  // namespace

PhaseShape::PhaseShape(std::vector<double> angle_deg, std::vector<double> log_phase)
    : angle_deg_(std::move(angle_deg)), log_phase_(std::move(log_phase)) {
  if (angle_deg_.size() < 4 || log_phase_.size() != angle_deg_.size() || angle_deg_.front() != 0 ||
      angle_deg_.back() != 180 || !std::is_sorted(angle_deg_.begin(), angle_deg_.end()))
    throw base::Error(base::Fault::bug, "phase function: angles must ascend from 0 to 180 degrees, one value each");
  slope_ = monotone_slopes(angle_deg_, log_phase_);
  const auto integral = [this](std::size_t first, std::size_t end) {
    const Nodes at = nodes(0, first, end);
    return std::inner_product(at.weight.begin(), at.weight.end(), at.value.begin(), 0.0);
  };
  const std::size_t intervals = angle_deg_.size() - 1;
  const double beyond = integral(1, intervals);
  if (std::abs(integral(0, 1) + beyond - 1) > kRoundingMiss && log_phase_[0] > log_phase_[1]) {
    // The integral grows with q: from the value at the second angle to that at 0 degrees, all over the first interval.
    double low = 0.02, high = 50;
    for (int i = 0; i < 60; ++i) {
      peak_exponent_ = std::sqrt(low * high);
      (integral(0, 1) + beyond < 1 ? low : high) = peak_exponent_;
    }
  }
  const double rest = std::log(integral(0, 1) + beyond);
  for (double& value : log_phase_) value -= rest;
  kept_ = integrate(kKeptMoments - 1);
  backward_ = std::exp(log_phase_.back());
}

double PhaseShape::log_at(double angle_deg) const {
  const std::size_t above =
      static_cast<std::size_t>(std::upper_bound(angle_deg_.begin(), angle_deg_.end(), angle_deg) - angle_deg_.begin());
  const std::size_t i = std::clamp<std::size_t>(above, 1, angle_deg_.size() - 1) - 1;
  const double width = angle_deg_[i + 1] - angle_deg_[i], t = std::clamp((angle_deg - angle_deg_[i]) / width, 0.0, 1.0);
  if (i == 0 && peak_exponent_ > 0)
    return log_phase_[1] + (log_phase_[0] - log_phase_[1]) * (1 - std::pow(t, peak_exponent_));
  const double s = 1 - t;
  return s * s * ((1 + 2 * t) * log_phase_[i] + t * width * slope_[i]) +
         t * t * ((1 + 2 * s) * log_phase_[i + 1] - s * width * slope_[i + 1]);
}

double PhaseShape::value(double cos_angle) const {
  // 2 asin sqrt((1 - c) / 2): no digits are lost near 0 degrees, where acos loses half of them.
  const double half = std::clamp((1 - cos_angle) / 2, 0.0, 1.0);
  return std::exp(log_at(2 * std::asin(std::sqrt(half)) / base::rad_from_deg(1)));
}

PhaseShape::Nodes PhaseShape::nodes(std::size_t last, std::size_t first, std::size_t end) const {
  Nodes out;
  GaussRule rule;
  for (std::size_t i = first; i < end; ++i) {
    const double from = base::rad_from_deg(angle_deg_[i]),
                 width = base::rad_from_deg(angle_deg_[i + 1] - angle_deg_[i]);
    // P_k turns once per 2 pi / k; the cubic and its exponential need few nodes, the peak many close to 0 degrees.
    const bool peak = i == 0;
    const std::size_t wanted = (peak ? 64 : 20) + static_cast<std::size_t>(static_cast<double>(last) * width);
    if (rule.node.size() != wanted) rule = gauss_legendre_rule(wanted);
    for (std::size_t j = 0; j < rule.node.size(); ++j) {
      const double u = (1 + rule.node[j]) / 2;
      const double angle = from + width * (peak ? u * u * u : u), stretch = peak ? 3 * u * u : 1;
      out.cosine.push_back(std::cos(angle));
      out.weight.push_back(rule.weight[j] / 4 * width * stretch * std::sin(angle));
      out.value.push_back(std::exp(log_at(angle / base::rad_from_deg(1))));
    }
  }
  return out;
}

std::vector<double> PhaseShape::integrate(std::size_t last) const {
  const Nodes at = nodes(last, 0, angle_deg_.size() - 1);
  std::vector<double> out(last + 1, 0);
  for (std::size_t j = 0; j < at.cosine.size(); ++j) {
    const double share = at.weight[j] * at.value[j], mu = at.cosine[j];
    double before = 0, now = 1;
    for (std::size_t k = 0; k <= last; ++k) {
      out[k] += share * now;
      const double order = static_cast<double>(k);
      const double next = ((2 * order + 1) * mu * now - order * before) / (order + 1);
      before = now, now = next;
    }
  }
  return out;
}

std::vector<double> PhaseShape::moments(std::size_t last) const {
  if (last < kKeptMoments) return {kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(last) + 1};
  return integrate(last);
}

}  // namespace raycube::atmos
