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

/// A maximum of the smoothed waveform with the bins that belong to it, [left, right).
struct Peak {
  std::size_t at = 0, left = 0, right = 0;
};

class Finder {
 public:
  Finder(const scene::Lidar& lidar, const std::vector<float>& waveform, const DetectorNoise& noise)
      : lidar_(lidar), noise_(noise), sigma_bins_(std::max(recorded_sigma_s(lidar) / lidar.gate.bin_s, 0.3)) {
    for (std::size_t i = 0; i < waveform.size(); ++i) raw_.push_back(waveform[i] - noise.background - noise.air_at(i));
    noisy_ = noise.drawn && (noise.excess > 0 || noise.floor > 0);
    if (noisy_ && sigma_bins_ > 0.6) smoothing_bins_ = 0.5 * sigma_bins_;
    const std::vector<double> taps = response_taps(base::kFwhmOfSigma * smoothing_bins_, 1);
    smooth_ = convolve(raw_, taps);
    white_ = sum_of_squares(taps), shot_ = sum_of_squares(combine(taps, noise.response));
  }

  std::vector<Echo> echoes() {
    std::vector<Echo> out;
    const std::vector<Peak> peaks = find_peaks();
    if (lidar_.echoes.method != scene::EchoMethod::gaussian) {
      for (const Peak& peak : peaks) out.push_back(measure(peak));
      return out;
    }
    for (std::size_t first = 0; first < peaks.size();) {
      std::size_t last = first + 1;
      while (last < peaks.size() && last - first < 6 && peaks[last].left <= peaks[last - 1].right + 1) ++last;
      fit_group({peaks.begin() + static_cast<std::ptrdiff_t>(first), peaks.begin() + static_cast<std::ptrdiff_t>(last)},
                out);
      first = last;
    }
    return out;
  }

 private:
  /// rms of the smoothed waveform about a bin where so much signal is expected.
  double smooth_rms(std::size_t bin, double signal) const {
    return std::sqrt(noise_.excess * (std::max(0.0, signal) + noise_.background + noise_.air_at(bin)) * shot_ +
                     noise_.floor * noise_.floor * white_);
  }

  bool above_threshold(std::size_t at) const {
    const auto half = static_cast<std::size_t>(std::max(1.0, std::ceil(0.5 * base::kFwhmOfSigma * sigma_bins_)));
    const std::size_t first = at > half ? at - half : 0, last = std::min(raw_.size(), at + half + 1);
    for (std::size_t i = first; i < last; ++i)
      if (reaches_threshold(lidar_, noise_, i, raw_[i])) return true;
    return false;
  }

  std::vector<Peak> find_peaks() const {
    const std::size_t bins = smooth_.size();
    std::vector<std::size_t> kept, valley;  // valley[i]: lowest bin between kept[i - 1] and kept[i]
    std::size_t lowest = 0;
    for (std::size_t i = 0; i < bins; ++i) {
      if (smooth_[i] < smooth_[lowest]) lowest = i;
      const bool maximum =
          smooth_[i] > 0 && (i == 0 || smooth_[i] > smooth_[i - 1]) && (i + 1 == bins || smooth_[i] >= smooth_[i + 1]);
      if (!maximum || !above_threshold(i)) continue;
      bool stands = true;
      while (!kept.empty()) {
        const double lower = std::min(smooth_[kept.back()], smooth_[i]), dip = lower - smooth_[lowest];
        // Two maxima near each other differ by chance less than the highest and lowest of a long plateau do.
        const bool far = static_cast<double>(i - kept.back()) > 4 * sigma_bins_,
                   apart = far && smooth_[lowest] < 0.5 * lower;
        if (apart || dip > std::max(1e-5 * lower, noisy_ ? (far ? 5 : 3) * smooth_rms(lowest, lower) : 0)) break;
        if (smooth_[i] <= smooth_[kept.back()]) {
          stands = false;
          break;
        }
        if (smooth_[valley.back()] < smooth_[lowest]) lowest = valley.back();
        kept.pop_back(), valley.pop_back();
      }
      if (!stands) continue;
      kept.push_back(i), valley.push_back(lowest);
      lowest = i;
    }
    std::vector<Peak> peaks;
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const double end = std::max(0.01 * smooth_[kept[k]], noisy_ ? 0.5 * smooth_rms(kept[k], 0) : 0);
      Peak peak{kept[k], kept[k], kept[k] + 1};
      const std::size_t from = k == 0 ? 0 : valley[k], to = k + 1 < kept.size() ? valley[k + 1] : bins;
      while (peak.left > from && smooth_[peak.left - 1] > end) --peak.left;
      while (peak.right < to && smooth_[peak.right] > end) ++peak.right;
      peaks.push_back(peak);
    }
    return peaks;
  }

  /// Where the smoothed waveform passes `level` going outwards from the peak, in bins (centres at + 1/2).
  double crossing(const Peak& peak, double level, int step) const {
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
  std::array<double, 2> vertex(std::size_t at) const {
    if (at == 0 || at + 1 >= smooth_.size()) return {0, smooth_[at]};
    double l = smooth_[at - 1], c = smooth_[at], r = smooth_[at + 1];
    const bool logs = l > 0 && r > 0;
    if (logs) l = std::log(l), c = std::log(c), r = std::log(r);
    const double bend = l - 2 * c + r;
    if (!(bend < 0)) return {0, smooth_[at]};
    const double offset = std::clamp(0.5 * (l - r) / bend, -0.5, 0.5), top = c - 0.25 * (l - r) * offset;
    return {offset, logs ? std::exp(top) : top};
  }

  bool saturated(std::size_t left, std::size_t right) const {
    if (!(noise_.full_scale > 0)) return false;
    for (std::size_t i = left; i < right; ++i)
      if (raw_[i] + noise_.background + noise_.air_at(i) >= noise_.full_scale * (1 - 1e-6)) return true;
    return false;
  }

  double highest(std::size_t left, std::size_t right) const {
    return *std::max_element(raw_.begin() + static_cast<std::ptrdiff_t>(left),
                             raw_.begin() + static_cast<std::ptrdiff_t>(right));
  }

  double width_bins(const Peak& peak) const {
    const double level = 0.5 * vertex(peak.at)[1], width = crossing(peak, level, 1) - crossing(peak, level, -1);
    const double spread = base::kFwhmOfSigma * std::hypot(smoothing_bins_, kBinSigma);
    return std::sqrt(std::max(width * width - spread * spread, 0.25));
  }

  Echo echo_at(double position_bins, double peak_pe, double area_pe, double fwhm_bins, bool is_saturated) const {
    Echo echo;
    echo.time_s = lidar_.gate.start_s + position_bins * lidar_.gate.bin_s;
    echo.peak_pe = static_cast<float>(peak_pe), echo.energy_pe = static_cast<float>(area_pe);
    echo.fwhm_s = static_cast<float>(fwhm_bins * lidar_.gate.bin_s);
    echo.saturated = is_saturated;
    return echo;
  }

  Echo measure(const Peak& peak) const {
    double position = static_cast<double>(peak.at) + 0.5, area = 0;
    for (std::size_t i = peak.left; i < peak.right; ++i) area += raw_[i];
    const auto [offset, top] = vertex(peak.at);
    if (lidar_.echoes.method == scene::EchoMethod::constant_fraction) {
      const double f = lidar_.echoes.fraction, sigma = std::hypot(sigma_bins_, smoothing_bins_, kBinSigma);
      position = crossing(peak, f * top, -1) + sigma * std::sqrt(-2 * std::log(f));
    } else {
      position += offset;
    }
    return echo_at(position, highest(peak.left, peak.right), area, width_bins(peak), saturated(peak.left, peak.right));
  }

  void fit_group(const std::vector<Peak>& peaks, std::vector<Echo>& out) const {
    const std::size_t margin = static_cast<std::size_t>(std::ceil(sigma_bins_));
    const std::size_t first = peaks.front().left > margin ? peaks.front().left - margin : 0,
                      last = std::min(raw_.size(), peaks.back().right + margin);
    std::vector<GaussianEcho> fitted;
    for (const Peak& peak : peaks) {
      // One echo's width comes from its own half height; among neighbours the recorded pulse is the better guess.
      const double sigma = peaks.size() == 1 ? std::max(width_bins(peak) / base::kFwhmOfSigma, 0.3) : sigma_bins_;
      const double share = std::erf(0.5 / (sigma * std::sqrt(2.0)));
      fitted.push_back({std::max(smooth_[peak.at], 1e-12) / share, static_cast<double>(peak.at) + 0.5, sigma});
    }
    double air = 0;
    for (std::size_t i = first; i < last; ++i) air = std::max(air, noise_.air_at(i));
    const double excess = noisy_ ? noise_.excess : 0;
    const double floor = noisy_ ? std::hypot(noise_.floor, std::sqrt(excess * (noise_.background + air)),
                                             kShapeError * highest(first, last))
                                : 0;
    double chi = fit_gaussians(raw_, first, last, floor, excess, fitted);
    while (fitted.size() < peaks.size() + 3 && 3 * fitted.size() + 3 < last - first &&
           chi > static_cast<double>(last - first) + 30) {
      std::vector<double> residual(raw_.size(), 0.0);
      for (std::size_t i = first; i < last; ++i) {
        residual[i] = raw_[i];
        for (const GaussianEcho& echo : fitted) residual[i] -= gaussian_bin(echo, static_cast<double>(i));
      }
      residual = convolve(residual, response_taps(base::kFwhmOfSigma * sigma_bins_, 1));
      const auto top = std::max_element(residual.begin() + static_cast<std::ptrdiff_t>(first),
                                        residual.begin() + static_cast<std::ptrdiff_t>(last));
      if (!(*top > 0)) break;
      std::vector<GaussianEcho> trial = fitted;
      trial.push_back({*top * 3.5 * sigma_bins_, static_cast<double>(top - residual.begin()) + 0.5, sigma_bins_});
      if (trial.size() == 2) split(fitted.front(), trial);
      const double trial_chi = fit_gaussians(raw_, first, last, floor, excess, trial);
      // No echo is narrower than the pulse; and what is much wider is air or leaves, which no number of Gaussians
      // describes.
      const bool echoes_all =
          std::all_of(trial.begin(), trial.end(),
                      [&](const GaussianEcho& e) {
                        return e.area * std::erf(0.5 / (e.sigma * std::sqrt(2.0))) >= noise_.threshold &&
                               e.sigma > 0.6 * sigma_bins_;
                      }) &&
          wide(trial) <= wide(fitted);
      if (!(trial_chi < chi - 30) || !echoes_all) break;
      chi = trial_chi, fitted = std::move(trial);
    }
    std::sort(fitted.begin(), fitted.end(),
              [](const GaussianEcho& a, const GaussianEcho& b) { return a.position < b.position; });
    for (const GaussianEcho& echo : fitted) {
      const double reach = std::max(1.0, 2 * echo.sigma);
      const auto left = static_cast<std::size_t>(std::max(0.0, std::floor(echo.position - reach)));
      const auto right = std::min(raw_.size(), static_cast<std::size_t>(std::ceil(echo.position + reach)));
      out.push_back(echo_at(echo.position, echo.area * std::erf(0.5 / (echo.sigma * std::sqrt(2.0))), echo.area,
                            base::kFwhmOfSigma * echo.sigma, saturated(left, right)));
    }
  }

  std::ptrdiff_t wide(const std::vector<GaussianEcho>& echoes) const {
    return std::count_if(echoes.begin(), echoes.end(),
                         [&](const GaussianEcho& e) { return e.sigma > 3 * sigma_bins_; });
  }

  /// Two echoes hidden under one maximum, wider than the pulse: half of the light to either side, with the same second
  /// moment.
  void split(const GaussianEcho& one, std::vector<GaussianEcho>& two) const {
    const double apart = std::sqrt(one.sigma * one.sigma - sigma_bins_ * sigma_bins_);
    if (!(apart > 0.2 * sigma_bins_)) return;
    two = {{0.5 * one.area, one.position - apart, sigma_bins_}, {0.5 * one.area, one.position + apart, sigma_bins_}};
  }

  const scene::Lidar& lidar_;
  const DetectorNoise& noise_;
  double sigma_bins_, smoothing_bins_ = 0, white_ = 1, shot_ = 1;
  bool noisy_ = false;
  std::vector<double> raw_, smooth_;
};

}  // namespace

std::vector<Echo> find_echoes(const scene::Lidar& lidar, const std::vector<float>& waveform_pe,
                              const DetectorNoise& noise) {
  std::vector<Echo> echoes = Finder(lidar, waveform_pe, noise).echoes();
  number_echoes(lidar, echoes);
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
  std::stable_sort(echoes.begin(), echoes.end(), [](const Echo& a, const Echo& b) { return a.time_s < b.time_s; });
  for (std::size_t i = 0; i < echoes.size(); ++i) {
    echoes[i].number = static_cast<int>(i) + 1, echoes[i].of = static_cast<int>(echoes.size());
    echoes[i].range_m = 0.5 * base::kLightSpeed_m_s * echoes[i].time_s / lidar.transport.group_index;
  }
}

}  // namespace raycube::lidar
