#include "host/lidar/detector.h"

#include <algorithm>
#include <cmath>

#include "host/base/units.h"
#include "host/base/wide.h"
#include "host/lidar/incomplete_gamma.h"
#include "host/lidar/speckle.h"

namespace raycube::lidar {

namespace {

double square(double x) { return x * x; }

/// P(count >= level) of Poisson counts, level whole.
double poisson_at_least(double level, double mean) {
  if (level <= 0) return 1;
  return level > 4096 || mean > 4096 ? count_at_least(level, 0, mean, 0) : gamma_p(level, mean);
}

/// Smallest count that Poisson noise exceeds no more often than that.
double count_quantile(double mean, double chance) {
  double level = std::floor(mean);
  while (poisson_at_least(level + 1, mean) > chance) level += std::max(1.0, std::floor(1e-3 * level));
  return level;
}

/// P(X >= value) of a gamma variate (Pearson III) shifted to mean 0, with this variance and skewness > 0.
double gamma_tail(double value, double sigma, double skewness) {
  const double shape = 4 / square(skewness), at = shape + value / sigma * std::sqrt(shape);
  return at > 0 ? std::clamp(1 - gamma_p(shape, at), 0.0, 1.0) : 1;
}

/// P(noise >= value) of a linear detector: avalanches and the floor beside them.
double linear_tail(const DetectorNoise& noise, double air, double value) {
  const double squares = square(noise.rms(air)) + (noise.air_modes > 0 ? square(air) / noise.air_modes : 0);
  if (!(squares > 0)) return value > 0 ? 0 : 1;
  const double avalanches = squares - square(noise.floor),
               third = noise.cubes * (noise.background + air) * noise.excess * (2 * noise.excess - 1);
  const double sigma = std::sqrt(std::max(avalanches, 0.0)), skewness = sigma > 0 ? third / (avalanches * sigma) : 0;
  if (noise.gaussian || skewness < 1e-3) return normal_tail(value / std::sqrt(squares));
  if (!(noise.floor > 1e-3 * sigma)) return gamma_tail(value, std::sqrt(squares), skewness);
  // The avalanches' tail, averaged over the Gaussian floor: the trapezoidal rule converges exponentially on a
  // Gaussian.
  constexpr double kStep = 0.5, kReach = 8;
  double sum = 0;
  for (double u = -kReach; u <= kReach; u += kStep)
    sum += std::exp(-0.5 * square(u)) * gamma_tail(value - noise.floor * u, sigma, skewness);
  return std::min(1.0, sum * kStep / std::sqrt(2 * M_PI));
}

/// Smallest value above the background that noise reaches no more often than bin_chance; linear. Logarithms
/// of tails are nearly straight: regula falsi (Illinois) between brackets.
double linear_threshold(const DetectorNoise& noise, double air) {
  const double rms = noise.rms(air), wanted = std::log(noise.bin_chance);
  if (!(rms > 0)) return 0;
  const auto above = [&](double value) { return std::log(std::max(linear_tail(noise, air, value), 1e-300)) - wanted; };
  double low = 0, high = 4 * rms, at_low = above(0), at_high = above(high);
  while (at_high > 0 && high < 1e6 * rms) low = high, at_low = at_high, high *= 1.5, at_high = above(high);
  if (at_low <= 0) return low;
  for (int i = 0; i < 60 && high - low > 1e-6 * high; ++i) {
    const double middle = low + (high - low) * at_low / (at_low - at_high), at = above(middle);
    if (at > 0)
      low = middle, at_low = at, at_high *= 0.5;
    else
      high = middle, at_high = at, at_low *= 0.5;
    if (std::abs(at) < 1e-6) return middle;
  }
  return high;
}

double threshold_about(const scene::Lidar& lidar, const DetectorNoise& noise, double air) {
  const scene::LidarEchoes& echoes = lidar.echoes;
  const double mean = noise.background + air;
  if (lidar.detector.mode != scene::DetectorMode::linear) {
    double level = count_quantile(mean, noise.bin_chance);
    if (noise.air_modes > 0)
      while (count_at_least(level + 1, air, noise.background, noise.air_modes) > noise.bin_chance)
        level += std::max(1.0, std::floor(1e-3 * level));
    return std::max(level + 0.5, std::ceil(echoes.threshold_pe) - 0.5) - mean;
  }
  if (noise.gaussian && !(air > 0)) return std::max(echoes.threshold_sigma * noise.rms(), echoes.threshold_pe);
  return std::max(linear_threshold(noise, air), echoes.threshold_pe);
}

RAYCUBE_WIDE void add_scaled(double factor, const double* from, double* to, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

}  // namespace

double excess_noise(double gain, double ionization_ratio) {
  return ionization_ratio * gain + (1 - ionization_ratio) * (2 - 1 / gain);
}

double linear_variance(double counts, double excess, double readout_e, double gain) {
  return excess * counts + square(readout_e / gain);
}

double DetectorNoise::rms(double signal) const {
  return std::sqrt(excess * (signal + background) * squares + square(floor));
}

std::vector<double> response_taps(double response_fwhm_s, double bin_s) {
  const double sigma_bins = base::kSigmaOfFwhm * response_fwhm_s / bin_s;
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

std::array<std::size_t, 2> convolve(const double* row, std::size_t begin, std::size_t end, std::size_t bins,
                                    const std::vector<double>& taps, double* to) {
  const std::size_t reach = taps.size() / 2, from = begin - std::min(begin, reach), past = std::min(bins, end + reach);
  if (begin >= end) return {begin, begin};
  std::fill(to + from, to + past, 0.0);
  // Tap by tap over the row: a loop that becomes vector instructions.
  for (std::size_t k = 0; k < taps.size(); ++k) {
    const std::size_t first = std::max(begin, reach - std::min(reach, k)),
                      last = std::min(end, bins + reach - std::min(bins + reach, k));
    if (first < last) add_scaled(taps[k], row + first, to + (first + k - reach), last - first);
  }
  return {from, past};
}

double recorded_sigma_s(const scene::Lidar& lidar) {
  const scene::LidarPulse& pulse = lidar.pulse;
  double variance = square(base::kSigmaOfFwhm * pulse.fwhm_s);
  if (pulse.shape == scene::PulseShape::rectangular) variance = square(pulse.fwhm_s) / 12;
  if (pulse.shape == scene::PulseShape::tabulated) {
    double area = 0, first = 0, second = 0;
    for (std::size_t i = 1; i < pulse.shape_time_s.size();
         ++i) {  // moments of straight pieces, exact by Simpson's rule up to cubics
      const double a = pulse.shape_time_s[i - 1], b = pulse.shape_time_s[i], m = 0.5 * (a + b),
                   p = pulse.shape_power[i - 1], q = pulse.shape_power[i];
      const double wide = (b - a) / 6, middle = 2 * (p + q);
      area += wide * (p + middle + q), first += wide * (p * a + middle * m + q * b),
          second += wide * (p * a * a + middle * m * m + q * b * b);
    }
    variance = area > 0 ? std::max(0.0, second / area - square(first / area)) : 0;
  }
  if (lidar.detector.mode == scene::DetectorMode::linear)
    variance += square(base::kSigmaOfFwhm * lidar.detector.response_fwhm_s);
  if (lidar.detector.mode == scene::DetectorMode::geiger)
    variance += square(base::kSigmaOfFwhm * lidar.detector.jitter_fwhm_s);
  return std::sqrt(variance);
}

NoiseOfRecords::NoiseOfRecords(const scene::Lidar& lidar) : lidar_(lidar) {
  const scene::LidarDetector& detector = lidar.detector;
  if (detector.mode == scene::DetectorMode::linear) {
    noise_.excess = excess_noise(detector.gain, detector.ionization_ratio);
    noise_.response = response_taps(detector.response_fwhm_s, lidar.gate.bin_s);
    noise_.squares = noise_.cubes = 0;
    for (const double share : noise_.response) noise_.squares += share * share, noise_.cubes += share * share * share;
  }
  noise_.gaussian = !(lidar.echoes.false_returns > 0);
  noise_.bin_chance = noise_.gaussian ? normal_tail(lidar.echoes.threshold_sigma)
                                      : std::min(0.5, lidar.echoes.false_returns / lidar.gate.bins);
}

const DetectorNoise& NoiseOfRecords::of(double background, double largest_signal) {
  const scene::LidarDetector& detector = lidar_.detector;
  noise_.background = background;
  if (detector.mode == scene::DetectorMode::linear) {
    noise_.floor = detector.readout_noise_e / detector.gain;
    noise_.full_scale = detector.full_scale_e;
    if (!(noise_.full_scale > 0))
      noise_.full_scale =
          std::exp2(std::ceil(std::log2(std::max(1.0, background + largest_signal + 6 * noise_.rms(largest_signal)))));
    const double step = noise_.full_scale / (std::exp2(detector.bits) - 1);
    noise_.floor = std::hypot(noise_.floor, step / std::sqrt(12.0));
  }
  for (const Known& known : known_)
    if (known.background == background && known.full_scale == noise_.full_scale) {
      noise_.threshold = known.threshold, noise_.alarms = known.alarms;
      return noise_;
    }
  noise_.threshold = threshold_about(lidar_, noise_, 0);
  noise_.alarms = alarm_chance(lidar_, noise_, 0);
  constexpr std::size_t kKept = 32;
  const Known fresh{background, noise_.full_scale, noise_.threshold, noise_.alarms};
  if (known_.size() < kKept)
    known_.push_back(fresh);
  else
    known_[oldest_++ % kKept] = fresh;
  return noise_;
}

DetectorNoise detector_noise(const scene::Lidar& lidar, double background, double largest_signal) {
  return NoiseOfRecords(lidar).of(background, largest_signal);
}

double alarm_chance(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin) {
  // A linear threshold lies where chance is bin_chance, or higher, at threshold_pe.
  const bool linear = lidar.detector.mode == scene::DetectorMode::linear;
  if (linear && !(noise.gaussian && noise.air.empty()))
    return std::min(noise.bin_chance, noise_chance(lidar, noise, bin, lidar.echoes.threshold_pe));
  return bin_detection(lidar, noise, bin, 0, 0);
}

double noise_chance(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin, double value) {
  const double air = noise.air_at(bin);
  if (lidar.detector.mode == scene::DetectorMode::linear) return linear_tail(noise, air, value);
  const double count = std::ceil(value + noise.background + air - 1e-6);  // single precision of the waveform
  return noise.air_modes > 0 && air > 0 ? count_at_least(count, air, noise.background, noise.air_modes)
                                        : poisson_at_least(count, noise.background + air);
}

bool reaches_threshold(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin, double value) {
  const double air = noise.air_at(bin);
  if (!(air > 0)) return value >= noise.threshold;
  if (!(value > 0)) return false;
  // Counts are whole: a threshold of 5.4 takes 6 of them, in air and out of it.
  const bool linear = lidar.detector.mode == scene::DetectorMode::linear;
  const double above = linear ? value : value + noise.background + air + 0.5;
  if (!(above >= (linear ? lidar.echoes.threshold_pe : std::ceil(lidar.echoes.threshold_pe)))) return false;
  // Skewness makes high values more likely than a Gaussian has them: what that allows too often needs no
  // second look.
  if (lidar.detector.mode == scene::DetectorMode::linear && normal_tail(value / noise.rms(air)) > noise.bin_chance)
    return false;
  return noise_chance(lidar, noise, bin, value) <= noise.bin_chance;
}

DetectorNoise noise_of_bin(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin) {
  DetectorNoise out = noise;
  const double air = noise.air_at(bin);
  if (air > 0) out.threshold = threshold_about(lidar, noise, air);
  out.background += air;
  out.air.clear();
  return out;
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
  for (std::size_t k = 0; k < counts; ++k)
    cumulated[k] = sum += negative_binomial_probability(static_cast<double>(k), background, 0);
  double below = 0;
  for (std::size_t k = 0; k < counts; ++k)
    below += negative_binomial_probability(static_cast<double>(k), signal, modes) * cumulated[counts - 1 - k];
  return std::clamp(1 - below, 0.0, 1.0);
}

double bin_detection(const scene::Lidar& lidar, const DetectorNoise& noise, double signal, double modes) {
  if (lidar.detector.mode != scene::DetectorMode::linear)
    return count_at_least(noise.background + noise.threshold, signal, noise.background, modes);
  const double variance = square(noise.rms(signal)) + (modes > 0 ? square(signal) / modes : 0);
  return variance > 0                ? normal_tail((noise.threshold - signal) / std::sqrt(variance))
         : signal >= noise.threshold ? 1
                                     : 0;
}

double bin_detection(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin, double signal,
                     double modes) {
  if (noise.air_at(bin) > 0) return bin_detection(lidar, noise_of_bin(lidar, noise, bin), signal, modes);
  return bin_detection(lidar, noise, signal, modes);
}

}  // namespace raycube::lidar
