// Gaussian decomposition: echoes fitted to a group of peaks, and what the same fit finds of the pulse itself.
#include <algorithm>
#include <cmath>

#include "host/base/units.h"
#include "host/lidar/echoes.h"
#include "host/lidar/pulse_taps.h"

namespace raycube::lidar {

namespace {

/// Bins of a return follow a Gaussian no better than this share of its peak: pulse and footprint are not exactly
/// Gaussian.
constexpr double kShapeError = 3e-4;
/// Without noise a fit takes every bin as known to this share of the highest.
constexpr double kWithoutNoise = 0.01;
constexpr std::size_t kMostMore = 3;  ///< components of a group beside its peaks
/// Two equal pulses under one maximum are together at most sqrt(2) times as wide as one.
constexpr double kWiderThanTwo = 1.5;
/// A return is symmetric below this skewness: a pulse of half the light, as near as it can be without a maximum of its
/// own, brings 0.3.
constexpr double kSymmetric = 0.2;
constexpr int kPhases = 8;  ///< of a bin, at which the pulse itself is measured
constexpr std::size_t kKnownLate = 16;

/// Rounded to a twelfth: what a fit finds of the pulse changes slowly with its strength.
double about(double value) { return value > 0 ? std::exp2(std::round(6 * std::log2(value)) / 6) : 0; }

}  // namespace

/// The pulse as recorded at some phases of a bin, and what peak and constant_fraction find of it.
void EchoFinder::calibrate() {
  const bool linear = lidar_.detector.mode == scene::DetectorMode::linear;
  const double bin_s = lidar_.gate.bin_s;
  const std::vector<double> response = response_taps(linear ? lidar_.detector.response_fwhm_s : 0, bin_s);
  const PulseSpan span = pulse_span(lidar_.pulse);
  const double margin = std::ceil(6 * sigma_bins_) + static_cast<double>(response.size()) + 2;
  const double before = std::ceil(-span.begin_s / bin_s) + margin, after = std::ceil(span.end_s / bin_s) + margin;
  const auto bins = static_cast<std::size_t>(before + after) + 1;
  for (int phase = 0; phase < kPhases; ++phase) {
    PulseRow row;
    row.zero = before + (phase + 0.5) / kPhases;
    std::vector<double> light(bins);
    for (std::size_t i = 0; i < bins; ++i) {
      const double from = static_cast<double>(i) - row.zero;
      light[i] = pulse_share(lidar_.pulse, from * bin_s, (from + 1) * bin_s);
    }
    row.share.assign(bins, 0.0);
    convolve(light.data(), 0, bins, bins, response, row.share.data());
    pulse_rows_.push_back(std::move(row));
  }
  for (const Taps* taps : {&none_, &smoothing_}) {
    used_ = taps;
    double sum = 0;
    for (const PulseRow& row : pulse_rows_) {
      smooth_.assign(bins, 0.0);
      convolve(row.share.data(), 0, bins, bins, taps->taps, smooth_.data());
      shown_ = &smooth_;
      const auto top = std::max_element(smooth_.begin(), smooth_.end()) - smooth_.begin();
      sum += position_of(static_cast<std::size_t>(top)) - row.zero;
    }
    late_[taps == &smoothing_] = sum / kPhases;
  }
  std::vector<GaussianEcho> one = {nearest(pulse_rows_.front(), 1, 0, 0)};
  const auto& share = pulse_rows_.front().share;
  const double top = *std::max_element(share.begin(), share.end());
  for (std::size_t i = 0; i < bins; ++i)
    pulse_shape_error_ =
        std::max(pulse_shape_error_, std::abs(share[i] - gaussian_bin(one.front(), static_cast<double>(i))) / top);
  smooth_.clear(), raw_.clear(), touched_ = {0, 0};
}

/// The Gaussian that a fit finds of a pulse of so many photo-electrons, in bins of such noise.
GaussianEcho EchoFinder::nearest(const PulseRow& row, double area, double floor, double excess) {
  std::vector<double> data = row.share;
  double centre = 0;
  for (std::size_t i = 0; i < data.size(); ++i) centre += data[i] * (static_cast<double>(i) + 0.5), data[i] *= area;
  std::vector<GaussianEcho> one = {{area, centre, sigma_bins_}};
  pulse_fit_.roughly(data, 0, data.size(), floor, excess, one);
  pulse_fit_.finish(floor, excess, one);
  return one.front();
}

/// Of an echo fitted with such noise.
const EchoFinder::Late& EchoFinder::late_of_fit(double area, double floor, double excess) {
  area = about(area), floor = about(floor);
  for (const KnownLate& known : known_late_)
    if (known.area == area && known.floor == floor && known.excess == excess) return known.late;
  KnownLate found{area, floor, excess, {0, 0}};
  for (const PulseRow& row : pulse_rows_) {
    const GaussianEcho one = nearest(row, area, floor, excess);
    found.late.bins += (one.position - row.zero) / kPhases, found.late.area += one.area / area / kPhases;
  }
  if (known_late_.size() < kKnownLate) known_late_.emplace_back();
  KnownLate& kept = known_late_[oldest_late_];
  oldest_late_ = (oldest_late_ + 1) % kKnownLate;
  return (kept = found).late;
}

double EchoFinder::own_shape_error() const { return std::max(kShapeError, pulse_shape_error_); }

double EchoFinder::pulse_late_s() {
  if (gaussian_pulse_) return 0;
  const bool fitted = lidar_.echoes.method == scene::EchoMethod::gaussian;
  return lidar_.gate.bin_s * (fitted ? late_of_fit(1e6, 1e6 * own_shape_error(), 1).bins : late_[1]);
}

/// Gaussians of a group of peaks, fitted_, one each, and what they were fitted with.
EchoFinder::Group EchoFinder::fit_peaks(std::size_t first_peak, std::size_t last_peak) {
  const auto margin = static_cast<std::size_t>(std::ceil(sigma_bins_));
  const std::size_t left_bin = peaks_[first_peak].left;
  Group group;
  group.first = left_bin - std::min(left_bin, margin);
  group.last = std::min(raw_.size(), peaks_[last_peak - 1].right + margin);
  fitted_.clear();
  for (std::size_t k = first_peak; k < last_peak; ++k) {
    const Peak& peak = peaks_[k];
    // One echo's width comes from its own half height; among neighbours the recorded pulse is the better guess.
    const double sigma =
        last_peak - first_peak == 1 ? std::max(width_bins(peak.at) / base::kFwhmOfSigma, 0.3) : sigma_bins_;
    const double share = std::erf(0.5 / (sigma * std::sqrt(2.0)));
    fitted_.push_back({std::max(smooth_[peak.at], 1e-12) / share, static_cast<double>(peak.at) + 0.5, sigma});
  }
  double air = 0;
  if (!noise_->air.empty())
    for (std::size_t i = group.first; i < group.last; ++i) air = std::max(air, noise_->air[i]);
  group.excess = noisy_ ? noise_->excess : 0;
  // Another echo is looked for in what neither the waveform's own error nor the pulse's shape explains.
  const double top = highest(group.first, group.last);
  double of_rays = ray_noise(group.first, std::max(top, 0.0));
  for (std::size_t i = group.first; i < group.last && !surfaces_.empty(); ++i)
    of_rays = std::max(of_rays, ray_noise(i, 0));
  const double error = top > 0 ? std::max(own_shape_error(), of_rays / top) : own_shape_error();
  const double drawn = std::hypot(noise_->floor, std::sqrt(group.excess * (noise_->background + air)));
  group.floor = noisy_ ? std::hypot(drawn, error * top) : error > kWithoutNoise ? error * top : 0;
  group.last_floor = noisy_ ? std::hypot(drawn, own_shape_error() * top) : group.floor;
  group.chi = fit_.roughly(raw_, group.first, group.last, group.floor, group.excess, fitted_);
  return group;
}

void EchoFinder::fit_group(std::size_t first_peak, std::size_t last_peak, std::vector<Echo>& out) {
  Group group = fit_peaks(first_peak, last_peak);
  static_assert(kMostPeaks + kMostMore <= GaussianFit::kMostEchoes);
  const std::size_t bins = group.last - group.first,
                    most = last_peak - first_peak == 1 && is_of_one_slope(peaks_[first_peak])
                               ? 1
                               : fitted_.size() + kMostMore;
  while (fitted_.size() < most && 3 * fitted_.size() + 3 < bins && group.chi > static_cast<double>(bins) + 30 &&
         add_component(group.first, group.last, group.chi, group.floor, group.excess)) {
  }
  fit_.finish(group.last_floor, group.excess, fitted_);
  std::sort(fitted_.begin(), fitted_.end(),
            [](const GaussianEcho& a, const GaussianEcho& b) { return a.position < b.position; });
  for (const GaussianEcho& echo : fitted_) {
    const double reach = std::max(1.0, 2 * echo.sigma);
    const auto left = static_cast<std::size_t>(std::max(0.0, std::floor(echo.position - reach)));
    const auto right = std::min(raw_.size(), static_cast<std::size_t>(std::ceil(echo.position + reach)));
    const Late late = gaussian_pulse_ ? Late() : late_of_fit(echo.area, group.last_floor, group.excess);
    out.push_back(echo_at(echo.position - late.bins, echo.area * std::erf(0.5 / (echo.sigma * std::sqrt(2.0))),
                          echo.area / late.area, base::kFwhmOfSigma * echo.sigma, saturated(left, right)));
  }
}

/// An even beam on a slope sends back what is flat and ends steeply: no Gaussian, and not several either. So is taken
/// what one Gaussian fits widely and whose two sides are alike.
bool EchoFinder::is_of_one_slope(const Peak& peak) const {
  if (lidar_.pulse.profile != scene::BeamProfile::uniform || fitted_.front().sigma < kWiderThanTwo * sigma_bins_)
    return false;
  double light = 0, first = 0, second = 0, third = 0;
  for (std::size_t i = peak.left; i < peak.right; ++i)
    light += smooth_[i], first += smooth_[i] * static_cast<double>(i - peak.left);
  const double mean = first / light;
  for (std::size_t i = peak.left; i < peak.right; ++i) {
    const double off = static_cast<double>(i - peak.left) - mean;
    second += smooth_[i] * off * off / light, third += smooth_[i] * off * off * off / light;
  }
  return std::abs(third) < kSymmetric * second * std::sqrt(second);
}

/// Where what the fit leaves over is highest another component is tried; whether it stays.
bool EchoFinder::add_component(std::size_t first, std::size_t last, double& chi, double floor, double excess) {
  residual_ = raw_;
  residual_smooth_.resize(raw_.size());
  for (std::size_t i = first; i < last; ++i)
    for (const GaussianEcho& echo : fitted_) residual_[i] -= gaussian_bin(echo, static_cast<double>(i));
  convolve(residual_.data(), first, last, residual_.size(), pulse_taps_, residual_smooth_.data());
  const auto top = std::max_element(residual_smooth_.begin() + static_cast<std::ptrdiff_t>(first),
                                    residual_smooth_.begin() + static_cast<std::ptrdiff_t>(last));
  if (!(*top > 0)) return false;
  trial_ = fitted_;
  trial_.push_back({*top * 3.5 * sigma_bins_, static_cast<double>(top - residual_smooth_.begin()) + 0.5, sigma_bins_});
  if (trial_.size() == 2) split(fitted_.front(), trial_);
  const double trial_chi = fit_.again(trial_);
  // No echo is narrower than the pulse; and what is much wider is air or leaves, which no number of Gaussians
  // describes.
  const bool echoes_all =
      std::all_of(trial_.begin(), trial_.end(),
                  [&](const GaussianEcho& e) {
                    return e.area * std::erf(0.5 / (e.sigma * std::sqrt(2.0))) >= noise_->threshold &&
                           e.sigma > 0.6 * sigma_bins_;
                  }) &&
      wide(trial_) <= wide(fitted_);
  if (!(trial_chi < chi - 30) || !echoes_all) return false;
  chi = fit_.weigh_anew(floor, excess);
  std::swap(fitted_, trial_);
  return true;
}

std::ptrdiff_t EchoFinder::wide(const std::vector<GaussianEcho>& echoes) const {
  return std::count_if(echoes.begin(), echoes.end(), [&](const GaussianEcho& e) { return e.sigma > 3 * sigma_bins_; });
}

/// Two echoes hidden under one maximum, wider than the pulse: half of the light to either side, with the same second
/// moment.
void EchoFinder::split(const GaussianEcho& one, std::vector<GaussianEcho>& two) const {
  const double apart = std::sqrt(one.sigma * one.sigma - sigma_bins_ * sigma_bins_);
  if (!(apart > 0.2 * sigma_bins_)) return;
  two = {{0.5 * one.area, one.position - apart, sigma_bins_}, {0.5 * one.area, one.position + apart, sigma_bins_}};
}

}  // namespace raycube::lidar
