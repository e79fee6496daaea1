#include "host/lidar/echoes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/base/units.h"
#include "host/lidar/gaussian_fit.h"
#include "host/lidar/pulse_taps.h"

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

bool any_reaches(const double* bins, std::size_t count, double threshold) {
  unsigned any = 0;
  for (std::size_t i = 0; i < count; ++i) any |= static_cast<unsigned>(bins[i] >= threshold);
  return any != 0;
}

/// Those whose middle is within half a recorded pulse of an end of the gate, or beyond it.
void mark_cut(const scene::Lidar& lidar, double sigma_s, std::vector<Echo>& echoes) {
  const double half_s = 0.5 * base::kFwhmOfSigma * sigma_s, begin_s = lidar.gate.start_s,
               end_s = begin_s + lidar.gate.bins * lidar.gate.bin_s;
  for (Echo& echo : echoes) echo.cut = echo.time_s < begin_s + half_s || echo.time_s > end_s - half_s;
}

/// Of a return's highest bin: what is looked at without smoothing.
constexpr double kUpper = 0.25;
/// A sub-ray or two that stand alone within so many widths of the pulse of a return, or this part of its depth, are its
/// own: the outermost of a round beam lie apart as the footprint is wide, however short the pulse.
constexpr double kLoneRays = 2, kLoneWidths = 2, kLoneDepth = 0.25;
/// So are more of them, no more than the waveform's own error, where the gap is no wider than chance leaves in a slope
/// as thin as they are: exp(-5) of such gaps.
constexpr double kByChance = 5;
/// Dips of fewer standard deviations of the waveform's own error part no peaks.
constexpr double kRipple = 3;
/// A return whose flank is longer by so much than the pulse's may come from many ranges.
constexpr double kSteep = 1.2;

}  // namespace

EchoFinder::EchoFinder(const scene::Lidar& lidar, double waveform_error)
    : lidar_(lidar),
      sigma_bins_(std::max(recorded_sigma_s(lidar) / lidar.gate.bin_s, 0.3)),
      waveform_error_(waveform_error),
      gaussian_pulse_(lidar.pulse.shape == scene::PulseShape::gaussian) {
  smoothing_ = taps_of(sigma_bins_ > 0.6 ? 0.5 * sigma_bins_ : 0), none_ = taps_of(0);
  pulse_taps_ = response_taps(base::kFwhmOfSigma * sigma_bins_, 1);
  if (!gaussian_pulse_) calibrate();
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
  shown_ = &smooth_;
  for (std::size_t first = 0; first < peaks_.size();) {
    std::size_t last = first + 1;
    while (last < peaks_.size() && last - first < kMostPeaks && peaks_[last].left <= peaks_[last - 1].right + 1) ++last;
    if (lidar_.echoes.method == scene::EchoMethod::gaussian)
      fit_group(first, last, echoes);
    else if (last == first + 1)
      echoes.push_back(measure(peaks_[first]));
    else
      measure_group(first, last, echoes);
    first = last;
  }
  mark_cut(lidar_, sigma_bins_ * lidar_.gate.bin_s, echoes);
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
  light_ = 0;
  double squares = 0;
  if (waveform_error_ > 0)
    for (std::size_t i = begin; i < end; ++i) {
      const double light = surfaces_.empty() ? smooth_[i] : surfaces_[i];
      light_ += light, squares += light * light;
    }
  // Sub-rays fall as photons do, if more evenly: their variance goes with the light, as much as gives the record's own
  // error.
  per_light_ = light_ > 0 ? waveform_error_ * waveform_error_ * squares / light_ : 0;
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
      const double chance = noisy_ ? (far ? 5 : 3) * smooth_rms(lowest, lower) : 0,
                   ripple = is_steep(kept_.back(), -1) && is_steep(i, 1)
                                ? 0
                                : kRipple * ray_noise(smooth_[i] < smooth_[kept_.back()] ? i : kept_.back(), lower);
      if (apart || dip > std::max(1e-5 * lower, std::hypot(chance, ripple))) break;
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
  if (used_ != &none_)
    for (std::size_t k = 0; k < peaks_.size();)
      if (!split_unsmoothed(k)) ++k;
  if (waveform_error_ > 0) drop_lone_rays();
}

/// Whether a flank of a maximum falls to a tenth as soon as the pulse's own: one range alone is behind it.
bool EchoFinder::is_steep(std::size_t at, int step) const {
  const double fall_bins = std::hypot(sigma_bins_, used_->sigma_bins) * std::sqrt(2 * std::log(10.0));
  const auto most = static_cast<std::ptrdiff_t>(std::ceil(kSteep * fall_bins)),
             bins = static_cast<std::ptrdiff_t>(smooth_.size()), from = static_cast<std::ptrdiff_t>(at);
  for (std::ptrdiff_t n = 0; n <= most; ++n) {
    const std::ptrdiff_t i = from + step * n;
    if (i < 0 || i >= bins || smooth_[static_cast<std::size_t>(i)] < 0.1 * smooth_[at]) return true;
  }
  return false;
}

/// Bright returns that smoothing has run into one: a dip of 5 standard deviations between two bins of its upper part.
bool EchoFinder::split_unsmoothed(std::size_t k) {
  const Peak peak = peaks_[k];
  const auto first = raw_.begin() + static_cast<std::ptrdiff_t>(peak.left),
             last = raw_.begin() + static_cast<std::ptrdiff_t>(peak.right);
  const auto top = static_cast<std::size_t>(std::max_element(first, last) - raw_.begin());
  double most = 0;
  std::size_t other = top, valley = top;
  for (const int step : {-1, 1}) {
    std::size_t lowest = top;
    for (std::size_t i = top; i != (step < 0 ? peak.left : peak.right - 1);) {
      i = step < 0 ? i - 1 : i + 1;
      if (raw_[i] < raw_[lowest]) lowest = i;
      if (raw_[i] < kUpper * raw_[top]) continue;
      const double noise = noise_->rms(raw_[i] + noise_->air_at(i)), dip = raw_[i] - raw_[lowest];
      const double over = dip / std::hypot(5 * std::numbers::sqrt2 * noise, kRipple * ray_noise(i, raw_[i]));
      if (over > most) most = over, other = i, valley = lowest;
    }
  }
  if (!(most > 1)) return false;
  const std::size_t early = std::min(top, other), late = std::max(top, other);
  peaks_[k] = {early, peak.left, valley};
  peaks_.insert(peaks_.begin() + static_cast<std::ptrdiff_t>(k) + 1, Peak{late, valley, peak.right});
  return true;
}

/// Where the outermost sub-rays of a slope stand apart, each would be a return of its own. Only a return
/// that is itself stretched by more than the gap has such: what stands beside a narrow one is another surface.
void EchoFinder::drop_lone_rays() {
  const double a_ray = light_ / std::max(1, lidar_.transport.subrays);
  const double sigma = std::hypot(sigma_bins_, used_->sigma_bins),
               near = kLoneWidths * base::kFwhmOfSigma * sigma_bins_;
  // Of a pulse that one range alone sends back, what is above the hundredth at which a return is followed.
  const double reach = sigma * std::sqrt(2 * std::log(100.0));
  const auto depth_of = [&](const Peak& peak) { return static_cast<double>(peak.right - peak.left) - 2 * reach; };
  /// Whether `peak` is what stands apart of `other`.
  const auto is_of = [&](const Peak& peak, const Peak& other) {
    double light = 0, of_surfaces = 0;
    for (std::size_t i = peak.left; i < peak.right; ++i)
      light += smooth_[i], of_surfaces += surfaces_.empty() ? smooth_[i] : surfaces_[i];
    const Peak& early = peak.at < other.at ? peak : other;
    const Peak& late = peak.at < other.at ? other : peak;
    const double edges = static_cast<double>(late.left) - static_cast<double>(early.right), gap = edges + 2 * reach;
    const double depth = depth_of(other);
    if (edges >= std::max(near, kLoneDepth * depth) || depth <= gap || of_surfaces <= 0.5 * light) return false;
    const double by_chance = light / a_ray * gap / (gap + std::max(0.0, depth_of(peak)));
    return light < kLoneRays * a_ray || (light < waveform_error_ * light_ && by_chance < kByChance);
  };
  for (std::size_t k = 0; k < peaks_.size() && peaks_.size() > 1;) {
    if ((k > 0 && is_of(peaks_[k], peaks_[k - 1])) || (k + 1 < peaks_.size() && is_of(peaks_[k], peaks_[k + 1])))
      peaks_.erase(peaks_.begin() + static_cast<std::ptrdiff_t>(k)), k = 0;
    else
      ++k;
  }
}

/// Where the waveform that is measured passes `level` going outwards from a bin, in bins (centres at + 1/2).
double EchoFinder::crossing(std::size_t from, double level, int step) const {
  const std::vector<double>& row = *shown_;
  auto i = static_cast<std::ptrdiff_t>(from);
  const auto bins = static_cast<std::ptrdiff_t>(row.size());
  while (i + step >= 0 && i + step < bins && row[static_cast<std::size_t>(i + step)] > level) i += step;
  if (i + step < 0 || i + step >= bins) return static_cast<double>(i) + 0.5;
  const double here = row[static_cast<std::size_t>(i)], next = row[static_cast<std::size_t>(i + step)];
  double share = (here - level) / (here - next);
  if (i - step >= 0 && i - step < bins && next > 0 && here > level) {
    // Parabola through the logarithms of the two and the one before: exact for a Gaussian.
    const double y0 = std::log(here), y1 = std::log(next),
                 before = std::log(std::max(row[static_cast<std::size_t>(i - step)], 1e-300));
    const double bend = 0.5 * (y1 + before) - y0, slope = 0.5 * (y1 - before),
                 root = slope * slope - 4 * bend * (y0 - std::log(level));
    const double found = 2 * (y0 - std::log(level)) / (-slope + std::sqrt(std::max(root, 0.0)));
    if (root >= 0 && found >= 0 && found <= 1) share = found;
  }
  return static_cast<double>(i) + 0.5 + step * share;
}

/// Vertex of the parabola through the logarithms of the three bins about a maximum: offset in bins, and height.
std::array<double, 2> EchoFinder::vertex(std::size_t at) const {
  const std::vector<double>& row = *shown_;
  if (at == 0 || at + 1 >= row.size()) return {0, row[at]};
  double l = row[at - 1], c = row[at], r = row[at + 1];
  const bool logs = l > 0 && r > 0;
  if (logs) l = std::log(l), c = std::log(c), r = std::log(r);
  const double bend = l - 2 * c + r;
  if (!(bend < 0)) return {0, row[at]};
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

double EchoFinder::width_bins(std::size_t at) const {
  const double level = 0.5 * vertex(at)[1], width = crossing(at, level, 1) - crossing(at, level, -1);
  const double spread = base::kFwhmOfSigma * std::hypot(used_->sigma_bins, kBinSigma);
  return std::sqrt(std::max(width * width - spread * spread, 0.25));
}

/// Of the return whose maximum is at a bin, by the method, in bins; of a Gaussian its middle.
double EchoFinder::position_of(std::size_t at) const {
  const auto [offset, top] = vertex(at);
  if (lidar_.echoes.method != scene::EchoMethod::constant_fraction) return static_cast<double>(at) + 0.5 + offset;
  const double f = lidar_.echoes.fraction, sigma = std::hypot(sigma_bins_, used_->sigma_bins, kBinSigma);
  return crossing(at, f * top, -1) + sigma * std::sqrt(-2 * std::log(f));
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
  double area = 0;
  for (std::size_t i = peak.left; i < peak.right; ++i) area += raw_[i];
  return echo_at(position_of(peak.at) - late_[used_ == &smoothing_], highest(peak.left, peak.right), area,
                 width_bins(peak.at), saturated(peak.left, peak.right));
}

/// The smoothed waveform about a group of peaks, with Gaussians of all but one taken off: what is measured next.
void EchoFinder::show_without_others(std::size_t first_peak, std::size_t last_peak, std::size_t own) {
  alone_.resize(smooth_.size());
  const std::size_t left = peaks_[first_peak].left, right = peaks_[last_peak - 1].right;
  const std::size_t from = left - std::min<std::size_t>(left, 2), to = std::min(smooth_.size(), right + 2);
  for (std::size_t i = from; i < to; ++i) {
    double rest = smooth_[i];
    for (std::size_t k = first_peak; k < last_peak; ++k)
      if (k != own) rest -= gaussian_bin(bells_[k - first_peak], static_cast<double>(i));
    alone_[i] = std::max(rest, 0.0);
  }
  if (from > 0) alone_[from - 1] = 0;
  if (to < alone_.size()) alone_[to] = 0;
  shown_ = &alone_;
}

/// Peaks that overlap, by peak or constant_fraction: each is measured alone, fitted Gaussians of the others taken off.
void EchoFinder::measure_group(std::size_t first_peak, std::size_t last_peak, std::vector<Echo>& out) {
  const Group group = fit_peaks(first_peak, last_peak);
  fit_.finish(group.last_floor, group.excess, fitted_);
  bells_ = fitted_;
  for (GaussianEcho& bell : bells_) bell.sigma = std::hypot(bell.sigma, used_->sigma_bins);
  for (std::size_t k = first_peak; k < last_peak; ++k) {
    const Peak& peak = peaks_[k];
    const GaussianEcho& own = fitted_[k - first_peak];
    show_without_others(first_peak, last_peak, k);
    const auto begin = alone_.begin();
    const auto top = static_cast<std::size_t>(std::max_element(begin + static_cast<std::ptrdiff_t>(peak.left),
                                                               begin + static_cast<std::ptrdiff_t>(peak.right)) -
                                              begin);
    out.push_back(echo_at(position_of(top) - late_[used_ == &smoothing_], highest(peak.left, peak.right), own.area,
                          base::kFwhmOfSigma * own.sigma, saturated(peak.left, peak.right)));
  }
  shown_ = &smooth_;
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
  mark_cut(lidar, recorded_sigma_s(lidar), echoes);
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
