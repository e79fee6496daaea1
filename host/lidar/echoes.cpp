#include "host/lidar/echoes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/units.h"
#include "host/lidar/gaussian_fit.h"

namespace raycube::lidar {

namespace {

constexpr double kBinSigma = 0.28867513459481288;  // of a value spread over a bin, 1 / sqrt(12)

double sum_of_squares(const std::vector<double>& taps) {
  double sum = 0;
  for (const double tap : taps) sum += tap * tap;
  return sum;
}

/// Convolution of two sets of taps, whole.
std::vector<double> combine(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) out[i + j] += a[i] * b[j];
  return out;
}

/// Bins of a return follow a Gaussian no better than this share of its peak: pulse and footprint are not exactly
/// Gaussian.
constexpr double kShapeError = 3e-4;

bool any_reaches(const double* bins, std::size_t count, double threshold) {
  unsigned any = 0;
  for (std::size_t i = 0; i < count; ++i) any |= static_cast<unsigned>(bins[i] >= threshold);
  return any != 0;
}

constexpr std::size_t kMostPeaks = 6, kMostMore = 3;  ///< of a group fitted together; components beside them
static_assert(kMostPeaks + kMostMore <= GaussianFit::kMostEchoes);

}  // namespace

EchoFinder::EchoFinder(const scene::Lidar& lidar)
    : lidar_(lidar), sigma_bins_(std::max(recorded_sigma_s(lidar) / lidar.gate.bin_s, 0.3)) {
  smoothing_ = taps_of(sigma_bins_ > 0.6 ? 0.5 * sigma_bins_ : 0), none_ = taps_of(0);
  pulse_taps_ = response_taps(base::kFwhmOfSigma * sigma_bins_, 1);
}

EchoFinder::Taps EchoFinder::taps_of(double sigma_bins) const {
  Taps out;
  out.sigma_bins = sigma_bins;
  out.taps = response_taps(base::kFwhmOfSigma * sigma_bins, 1);
  const bool linear = lidar_.detector.mode == scene::DetectorMode::linear;
  out.white = sum_of_squares(out.taps);
  out.shot =
      sum_of_squares(combine(out.taps, response_taps(linear ? lidar_.detector.response_fwhm_s : 0, lidar_.gate.bin_s)));
  return out;
}

void EchoFinder::operator()(std::span<const float> waveform, std::size_t begin, std::size_t end,
                            const DetectorNoise& noise, std::vector<Echo>& echoes) {
  noise_ = &noise;
  if (raw_.size() != waveform.size()) raw_.assign(waveform.size(), 0.0), smooth_ = raw_, touched_ = {0, 0};
  std::fill(raw_.begin() + touched_[0], raw_.begin() + touched_[1], 0.0);
  std::fill(smooth_.begin() + touched_[0], smooth_.begin() + touched_[1], 0.0);
  for (std::size_t i = begin; i < end; ++i) raw_[i] = static_cast<double>(waveform[i]) - noise.background;
  if (!noise.air.empty())
    for (std::size_t i = begin; i < end; ++i) raw_[i] -= noise.air[i];
  noisy_ = noise.drawn && (noise.excess > 0 || noise.floor > 0);
  used_ = noisy_ ? &smoothing_ : &none_;
  const auto [from, past] = convolve(raw_.data(), begin, end, raw_.size(), used_->taps, smooth_.data());
  touched_ = {static_cast<std::ptrdiff_t>(from), static_cast<std::ptrdiff_t>(past)};
  find_peaks(from, past);
  echoes.clear();
  if (lidar_.echoes.method != scene::EchoMethod::gaussian) {
    for (const Peak& peak : peaks_) echoes.push_back(measure(peak));
  } else {
    for (std::size_t first = 0; first < peaks_.size();) {
      std::size_t last = first + 1;
      while (last < peaks_.size() && last - first < kMostPeaks && peaks_[last].left <= peaks_[last - 1].right + 1)
        ++last;
      fit_group(first, last, echoes);
      first = last;
    }
  }
  number_echoes(lidar_, echoes);
}

/// rms of the smoothed waveform about a bin where so much signal is expected.
double EchoFinder::smooth_rms(std::size_t bin, double signal) const {
  return std::sqrt(noise_->excess * (std::max(0.0, signal) + noise_->background + noise_->air_at(bin)) * used_->shot +
                   noise_->floor * noise_->floor * used_->white);
}

/// Bins that reach their threshold.
void EchoFinder::find_signal(std::size_t begin, std::size_t end) {
  signal_.clear();
  constexpr std::size_t kTogether = 16;
  for (std::size_t first = begin; first < end; first += kTogether) {
    const std::size_t past = std::min(end, first + kTogether);
    if (noise_->air.empty() && !any_reaches(raw_.data() + first, past - first, noise_->threshold)) continue;
    for (std::size_t i = first; i < past; ++i)
      if (reaches_threshold(lidar_, *noise_, i, raw_[i])) signal_.push_back(i);
  }
}

/// Maxima of the smoothed waveform with a signal's bin near them. Outside of begin .. end - 1 nothing is above 0.
void EchoFinder::find_peaks(std::size_t begin, std::size_t end) {
  const std::size_t bins = smooth_.size();
  const auto half = static_cast<std::size_t>(std::max(1.0, std::ceil(0.5 * base::kFwhmOfSigma * sigma_bins_)));
  find_signal(begin, end);
  const auto at = [&](std::size_t bin) { return smooth_.begin() + static_cast<std::ptrdiff_t>(bin); };
  kept_.clear(), valley_.clear(), peaks_.clear();
  std::size_t next = 0;  // of the bins with a signal
  for (std::size_t i = begin; i < end; ++i) {
    while (next < signal_.size() && signal_[next] + half < i) ++next;
    if (next == signal_.size()) break;
    if (signal_[next] > i + half) i = signal_[next] - half;
    const bool maximum =
        smooth_[i] > 0 && (i == 0 || smooth_[i] > smooth_[i - 1]) && (i + 1 == bins || smooth_[i] >= smooth_[i + 1]);
    if (!maximum) continue;
    std::size_t lowest =
        kept_.empty() ? begin
                      : static_cast<std::size_t>(std::min_element(at(kept_.back()), at(i + 1)) - smooth_.begin());
    bool stands = true;
    while (!kept_.empty()) {
      const double lower = std::min(smooth_[kept_.back()], smooth_[i]), dip = lower - smooth_[lowest];
      // Two maxima near each other differ by chance less than the highest and lowest of a long plateau do.
      const bool far = static_cast<double>(i - kept_.back()) > 4 * sigma_bins_,
                 apart = far && smooth_[lowest] < 0.5 * lower;
      if (apart || dip > std::max(1e-5 * lower, noisy_ ? (far ? 5 : 3) * smooth_rms(lowest, lower) : 0)) break;
      if (smooth_[i] <= smooth_[kept_.back()]) {
        stands = false;
        break;
      }
      if (smooth_[valley_.back()] < smooth_[lowest]) lowest = valley_.back();
      kept_.pop_back(), valley_.pop_back();
    }
    if (!stands) continue;
    kept_.push_back(i), valley_.push_back(lowest);
  }
  for (std::size_t k = 0; k < kept_.size(); ++k) {
    const double low = std::max(0.01 * smooth_[kept_[k]], noisy_ ? 0.5 * smooth_rms(kept_[k], 0) : 0);
    Peak peak{kept_[k], kept_[k], kept_[k] + 1};
    const std::size_t from = k == 0 ? 0 : valley_[k], to = k + 1 < kept_.size() ? valley_[k + 1] : bins;
    while (peak.left > from && smooth_[peak.left - 1] > low) --peak.left;
    while (peak.right < to && smooth_[peak.right] > low) ++peak.right;
    peaks_.push_back(peak);
  }
}

/// Where the smoothed waveform passes `level` going outwards from the peak, in bins (centres at + 1/2).
double EchoFinder::crossing(const Peak& peak, double level, int step) const {
  auto i = static_cast<std::ptrdiff_t>(peak.at);
  const auto bins = static_cast<std::ptrdiff_t>(smooth_.size());
  while (i + step >= 0 && i + step < bins && smooth_[static_cast<std::size_t>(i + step)] > level) i += step;
  if (i + step < 0 || i + step >= bins) return static_cast<double>(i) + 0.5;
  const double here = smooth_[static_cast<std::size_t>(i)], next = smooth_[static_cast<std::size_t>(i + step)];
  double share = (here - level) / (here - next);
  if (i - step >= 0 && i - step < bins && next > 0 && here > level) {
    // Parabola through the logarithms of the two and the one before: exact for a Gaussian.
    const double y0 = std::log(here), y1 = std::log(next),
                 before = std::log(std::max(smooth_[static_cast<std::size_t>(i - step)], 1e-300));
    const double bend = 0.5 * (y1 + before) - y0, slope = 0.5 * (y1 - before),
                 root = slope * slope - 4 * bend * (y0 - std::log(level));
    const double found = 2 * (y0 - std::log(level)) / (-slope + std::sqrt(std::max(root, 0.0)));
    if (root >= 0 && found >= 0 && found <= 1) share = found;
  }
  return static_cast<double>(i) + 0.5 + step * share;
}

/// Vertex of the parabola through the logarithms of the three bins about a maximum: offset in bins, and height.
std::array<double, 2> EchoFinder::vertex(std::size_t at) const {
  if (at == 0 || at + 1 >= smooth_.size()) return {0, smooth_[at]};
  double l = smooth_[at - 1], c = smooth_[at], r = smooth_[at + 1];
  const bool logs = l > 0 && r > 0;
  if (logs) l = std::log(l), c = std::log(c), r = std::log(r);
  const double bend = l - 2 * c + r;
  if (!(bend < 0)) return {0, smooth_[at]};
  const double offset = std::clamp(0.5 * (l - r) / bend, -0.5, 0.5), top = c - 0.25 * (l - r) * offset;
  return {offset, logs ? std::exp(top) : top};
}

bool EchoFinder::saturated(std::size_t left, std::size_t right) const {
  if (!(noise_->full_scale > 0)) return false;
  for (std::size_t i = left; i < right; ++i)
    if (raw_[i] + noise_->background + noise_->air_at(i) >= noise_->full_scale * (1 - 1e-6)) return true;
  return false;
}

double EchoFinder::highest(std::size_t left, std::size_t right) const {
  return *std::max_element(raw_.begin() + static_cast<std::ptrdiff_t>(left),
                           raw_.begin() + static_cast<std::ptrdiff_t>(right));
}

double EchoFinder::width_bins(const Peak& peak) const {
  const double level = 0.5 * vertex(peak.at)[1], width = crossing(peak, level, 1) - crossing(peak, level, -1);
  const double spread = base::kFwhmOfSigma * std::hypot(used_->sigma_bins, kBinSigma);
  return std::sqrt(std::max(width * width - spread * spread, 0.25));
}

Echo EchoFinder::echo_at(double position_bins, double peak_pe, double area_pe, double fwhm_bins,
                         bool is_saturated) const {
  Echo echo;
  echo.time_s = lidar_.gate.start_s + position_bins * lidar_.gate.bin_s;
  echo.peak_pe = static_cast<float>(peak_pe), echo.energy_pe = static_cast<float>(area_pe);
  echo.fwhm_s = static_cast<float>(fwhm_bins * lidar_.gate.bin_s);
  echo.saturated = is_saturated;
  return echo;
}

Echo EchoFinder::measure(const Peak& peak) const {
  double position = static_cast<double>(peak.at) + 0.5, area = 0;
  for (std::size_t i = peak.left; i < peak.right; ++i) area += raw_[i];
  const auto [offset, top] = vertex(peak.at);
  if (lidar_.echoes.method == scene::EchoMethod::constant_fraction) {
    const double f = lidar_.echoes.fraction, sigma = std::hypot(sigma_bins_, used_->sigma_bins, kBinSigma);
    position = crossing(peak, f * top, -1) + sigma * std::sqrt(-2 * std::log(f));
  } else {
    position += offset;
  }
  return echo_at(position, highest(peak.left, peak.right), area, width_bins(peak), saturated(peak.left, peak.right));
}

void EchoFinder::fit_group(std::size_t first_peak, std::size_t last_peak, std::vector<Echo>& out) {
  const auto margin = static_cast<std::size_t>(std::ceil(sigma_bins_));
  const std::size_t left_bin = peaks_[first_peak].left, first = left_bin - std::min(left_bin, margin),
                    last = std::min(raw_.size(), peaks_[last_peak - 1].right + margin);
  fitted_.clear();
  for (std::size_t k = first_peak; k < last_peak; ++k) {
    const Peak& peak = peaks_[k];
    // One echo's width comes from its own half height; among neighbours the recorded pulse is the better guess.
    const double sigma =
        last_peak - first_peak == 1 ? std::max(width_bins(peak) / base::kFwhmOfSigma, 0.3) : sigma_bins_;
    const double share = std::erf(0.5 / (sigma * std::sqrt(2.0)));
    fitted_.push_back({std::max(smooth_[peak.at], 1e-12) / share, static_cast<double>(peak.at) + 0.5, sigma});
  }
  double air = 0;
  if (!noise_->air.empty())
    for (std::size_t i = first; i < last; ++i) air = std::max(air, noise_->air[i]);
  const double excess = noisy_ ? noise_->excess : 0;
  const double floor = noisy_ ? std::hypot(noise_->floor, std::sqrt(excess * (noise_->background + air)),
                                           kShapeError * highest(first, last))
                              : 0;
  double chi = fit_.roughly(raw_, first, last, floor, excess, fitted_);
  const std::size_t most = fitted_.size() + kMostMore;
  while (fitted_.size() < most && 3 * fitted_.size() + 3 < last - first &&
         chi > static_cast<double>(last - first) + 30 && add_component(first, last, chi, floor, excess)) {
  }
  fit_.finish(floor, excess, fitted_);
  std::sort(fitted_.begin(), fitted_.end(),
            [](const GaussianEcho& a, const GaussianEcho& b) { return a.position < b.position; });
  for (const GaussianEcho& echo : fitted_) {
    const double reach = std::max(1.0, 2 * echo.sigma);
    const auto left = static_cast<std::size_t>(std::max(0.0, std::floor(echo.position - reach)));
    const auto right = std::min(raw_.size(), static_cast<std::size_t>(std::ceil(echo.position + reach)));
    out.push_back(echo_at(echo.position, echo.area * std::erf(0.5 / (echo.sigma * std::sqrt(2.0))), echo.area,
                          base::kFwhmOfSigma * echo.sigma, saturated(left, right)));
  }
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

std::vector<Echo> find_echoes(const scene::Lidar& lidar, const std::vector<float>& waveform_pe,
                              const DetectorNoise& noise) {
  std::vector<Echo> echoes;
  EchoFinder finder(lidar);
  finder(waveform_pe, 0, waveform_pe.size(), noise, echoes);
  return echoes;
}

std::vector<Echo> cluster_tags(const scene::Lidar& lidar, const std::vector<Photon>& tags) {
  const double gap_s = std::max(0.5 * base::kFwhmOfSigma * recorded_sigma_s(lidar), lidar.gate.bin_s);
  std::vector<Echo> echoes;
  for (std::size_t first = 0; first < tags.size();) {
    std::size_t last = first + 1;
    while (last < tags.size() && tags[last].time_s - tags[last - 1].time_s <= gap_s) ++last;
    const auto count = static_cast<double>(last - first);
    double mean = 0, squares = 0, most = 0;
    for (std::size_t i = first; i < last; ++i) mean += (tags[i].time_s - tags[first].time_s) / count;
    for (std::size_t i = first, j = first; i < last; ++i) {
      const double off = tags[i].time_s - tags[first].time_s - mean;
      squares += off * off / count;
      while (tags[i].time_s - tags[j].time_s > lidar.gate.bin_s) ++j;
      most = std::max(most, static_cast<double>(i - j + 1));
    }
    if (count >= lidar.echoes.threshold_pe) {
      Echo echo;
      echo.time_s = tags[first].time_s + mean;
      echo.peak_pe = static_cast<float>(most), echo.energy_pe = static_cast<float>(count);
      echo.fwhm_s = static_cast<float>(base::kFwhmOfSigma * std::sqrt(squares));
      echoes.push_back(echo);
    }
    first = last;
  }
  number_echoes(lidar, echoes);
  return echoes;
}

void number_echoes(const scene::Lidar& lidar, std::vector<Echo>& echoes) {
  const auto most = static_cast<std::size_t>(std::max(1, lidar.echoes.max_returns));
  if (echoes.size() > most) {
    std::stable_sort(echoes.begin(), echoes.end(),
                     [](const Echo& a, const Echo& b) { return a.energy_pe > b.energy_pe; });
    echoes.resize(most);
  }
  const auto earlier = [](const Echo& a, const Echo& b) { return a.time_s < b.time_s; };
  if (!std::is_sorted(echoes.begin(), echoes.end(), earlier)) std::stable_sort(echoes.begin(), echoes.end(), earlier);
  for (std::size_t i = 0; i < echoes.size(); ++i) {
    echoes[i].number = static_cast<int>(i) + 1, echoes[i].of = static_cast<int>(echoes.size());
    echoes[i].range_m = 0.5 * base::kLightSpeed_m_s * echoes[i].time_s / lidar.transport.group_index;
  }
}

}  // namespace raycube::lidar
