#include "host/lidar/detector.h"

#include <algorithm>
#include <cmath>

#include "host/lidar/speckle.h"

namespace raycube::lidar {

namespace {

constexpr double kSigmaOfFwhm = 0.42466090014400953;  // 1 / (2 sqrt(2 ln 2))

double square(double x) { return x * x; }

/// Smallest count that Poisson noise exceeds no more often than Gaussian noise exceeds so many standard deviations.
double count_quantile(double mean, double sigmas) {
  const double tail = normal_tail(sigmas);
  double level = std::floor(mean);
  while (count_at_least(level + 1, 0, mean, 0) > tail) level += std::max(1.0, std::floor(1e-3 * level));
  return level;
}

}  // namespace

double excess_noise(double gain, double ionization_ratio) {
  return ionization_ratio * gain + (1 - ionization_ratio) * (2 - 1 / gain);
}

double linear_variance(double counts, double excess, double readout_e, double gain) { return excess * counts + square(readout_e / gain); }

double DetectorNoise::rms(double signal) const {
  double squares = 0;
  for (const double share : response) squares += share * share;
  return std::sqrt(excess * (signal + background) * squares + square(floor));
}

std::vector<double> response_taps(double response_fwhm_s, double bin_s) {
  const double sigma_bins = kSigmaOfFwhm * response_fwhm_s / bin_s;
  if (sigma_bins < 1e-3) return {1};
  const int reach = static_cast<int>(std::ceil(6 * sigma_bins));
  std::vector<double> taps;
  double total = 0;
  for (int i = -reach; i <= reach; ++i) {
    taps.push_back(normal_tail((i - 0.5) / sigma_bins) - normal_tail((i + 0.5) / sigma_bins));
    total += taps.back();
  }
  for (double& tap : taps) tap /= total;
  return taps;
}

std::vector<double> convolve(const std::vector<double>& row, const std::vector<double>& taps) {
  if (taps.size() == 1) return row;
  // Tap by tap over the whole row: a loop that compilers turn into vector instructions.
  const auto reach = static_cast<std::ptrdiff_t>(taps.size() / 2), count = static_cast<std::ptrdiff_t>(row.size());
  std::vector<double> out(row.size(), 0.0);
  for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
    const double tap = taps[static_cast<std::size_t>(k + reach)];
    const double* const from = row.data();
    double* const to = out.data();
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, k), end = std::min(count, count + k); i < end; ++i) to[i] += tap * from[i - k];
  }
  return out;
}

double recorded_sigma_s(const scene::Lidar& lidar) {
  const scene::LidarPulse& pulse = lidar.pulse;
  double variance = square(kSigmaOfFwhm * pulse.fwhm_s);
  if (pulse.shape == scene::PulseShape::rectangular) variance = square(pulse.fwhm_s) / 12;
  if (pulse.shape == scene::PulseShape::tabulated) {
    double area = 0, first = 0, second = 0;
    for (std::size_t i = 1; i < pulse.shape_time_s.size(); ++i) {  // moments of straight pieces, exact by Simpson's rule up to cubics
      const double a = pulse.shape_time_s[i - 1], b = pulse.shape_time_s[i], m = 0.5 * (a + b), p = pulse.shape_power[i - 1], q = pulse.shape_power[i];
      const double wide = (b - a) / 6, middle = 2 * (p + q);
      area += wide * (p + middle + q), first += wide * (p * a + middle * m + q * b), second += wide * (p * a * a + middle * m * m + q * b * b);
    }
    variance = area > 0 ? std::max(0.0, second / area - square(first / area)) : 0;
  }
  if (lidar.detector.mode == scene::DetectorMode::linear) variance += square(kSigmaOfFwhm * lidar.detector.response_fwhm_s);
  if (lidar.detector.mode == scene::DetectorMode::geiger) variance += square(kSigmaOfFwhm * lidar.detector.jitter_fwhm_s);
  return std::sqrt(variance);
}

DetectorNoise detector_noise(const scene::Lidar& lidar, double background, double largest_signal) {
  const scene::LidarDetector& detector = lidar.detector;
  DetectorNoise noise;
  noise.background = background;
  if (detector.mode == scene::DetectorMode::linear) {
    noise.excess = excess_noise(detector.gain, detector.ionization_ratio);
    noise.floor = detector.readout_noise_e / detector.gain;
    noise.response = response_taps(detector.response_fwhm_s, lidar.gate.bin_s);
    noise.full_scale = detector.full_scale_e;
    if (!(noise.full_scale > 0)) noise.full_scale = std::exp2(std::ceil(std::log2(std::max(1.0, background + largest_signal + 6 * noise.rms(largest_signal)))));
    const double step = noise.full_scale / (std::exp2(detector.bits) - 1);
    noise.floor = std::hypot(noise.floor, step / std::sqrt(12.0));
  }
  if (detector.mode == scene::DetectorMode::linear)
    noise.threshold = std::max(lidar.echoes.threshold_sigma * noise.rms(), lidar.echoes.threshold_pe);
  else
    noise.threshold = std::max(count_quantile(background, lidar.echoes.threshold_sigma) + 0.5, std::ceil(lidar.echoes.threshold_pe) - 0.5) - background;
  return noise;
}

double normal_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

double count_at_least(double level, double signal, double background, double modes) {
  if (level <= 0) return 1;
  const double mean = signal + background, highest = std::ceil(level) - 1;  // of the counts that do not reach it
  if (std::max(highest, mean) > 4096) {
    const double variance = mean + (modes > 0 ? square(signal) / modes : 0);
    return normal_tail((highest + 0.5 - mean) / std::sqrt(variance));
  }
  // P(S + B <= highest): cumulated Poisson background under each count of the signal.
  const auto counts = static_cast<std::size_t>(highest) + 1;
  std::vector<double> cumulated(counts);
  double sum = 0;
  for (std::size_t k = 0; k < counts; ++k) cumulated[k] = sum += negative_binomial_probability(static_cast<double>(k), background, 0);
  double below = 0;
  for (std::size_t k = 0; k < counts; ++k) below += negative_binomial_probability(static_cast<double>(k), signal, modes) * cumulated[counts - 1 - k];
  return std::clamp(1 - below, 0.0, 1.0);
}

double bin_detection(const scene::Lidar& lidar, const DetectorNoise& noise, double signal, double modes) {
  if (lidar.detector.mode != scene::DetectorMode::linear) return count_at_least(noise.background + noise.threshold, signal, noise.background, modes);
  const double variance = square(noise.rms(signal)) + (modes > 0 ? square(signal) / modes : 0);
  return variance > 0 ? normal_tail((noise.threshold - signal) / std::sqrt(variance)) : signal >= noise.threshold ? 1 : 0;
}

}  // namespace raycube::lidar
