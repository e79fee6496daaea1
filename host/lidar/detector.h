// Parts of detection that know no files and no plan: expectations of a row in photo-electrons, noise, thresholds,
// probabilities.
#pragma once

#include <array>
#include <vector>

#include "host/lidar/detection.h"
#include "scene_compiler/lidar_spec.h"

namespace raycube::lidar {

/// What a record's noise is made of, primary photo-electrons.
struct DetectorNoise {
  double background = 0;  ///< mean a bin
  double excess = 1;      ///< variance of a bin per expected photo-electron: F (linear), 1 (photons, geiger)
  double floor = 0;       ///< rms of readout and digitiser, a bin
  std::vector<double> response{
      1};  ///< shares of neighbouring bins, middle one in the middle; white noise of `floor` comes after
  double squares = 1, cubes = 1;  ///< sums of the response's, which noise and its skewness go by
  double threshold = 0;           ///< above the background, where there is no air; a peak that reaches it counts
  double bin_chance = 0;          ///< of noise reaching a bin's threshold, air or not
  double alarms = 0;              ///< chance that noise does, where there is no air
  bool gaussian = true;           ///< linear: the noise counts as Gaussian (threshold_sigma); else with its skewness
                                  ///< (false_returns)
  double full_scale = 0;          ///< photo-electrons; 0: none
  /// Mean a bin of the air's return, after the response, where it counts as background; empty: none.
  std::vector<double> air;
  double air_modes = 0;  ///< speckle modes of it; 0: no speckle
  bool drawn = true;     ///< false: of a waveform without noise (expectations), judged by the same thresholds

  double air_at(std::size_t bin) const { return air.empty() ? 0 : air[bin]; }
  double rms(double signal = 0) const;  ///< of a bin with that expected signal, after the response
};

/// F = k M + (1 - k)(2 - 1/M), McIntyre, IEEE Trans. ED 13 (1966) 164; 1 for gain 1.
double excess_noise(double gain, double ionization_ratio);
/// Variance of a bin, primary photo-electrons squared: F (signal + background + dark) + (readout / gain)^2.
double linear_variance(double counts, double excess, double readout_e, double gain);

/// Shares of the electronics' Gaussian impulse response in bins about the middle of one; {1} for 0 s.
std::vector<double> response_taps(double response_fwhm_s, double bin_s);
/// Convolution of bins begin .. end - 1 of a row of `bins`, the others being 0: written to bins as far around them as
/// the taps reach, of `to` those alone. Returns them, [0] to before [1]; what leaves the row is lost.
std::array<std::size_t, 2> convolve(const double* row, std::size_t begin, std::size_t end, std::size_t bins,
                                    const std::vector<double>& taps, double* to);

/// Standard deviation of an echo of a flat target as recorded: pulse and electronics, s.
double recorded_sigma_s(const scene::Lidar& lidar);

/// Noise of photons and linear detectors for a row whose largest expectation (signal alone) is given.
/// Thresholds: what noise reaches in a bin no more often than bin_chance, false_returns over the bins of a
/// record or a Gaussian's tail beyond threshold_sigma, and at least threshold_pe (linear: above the
/// background; photons: counts in all). Few counts are no Gaussian: 4 sigma of 0.1 counts would be met by
/// chance once in 200 bins, so photons are judged by Poisson's law and, with false_returns, avalanches with
/// their skewness.
class NoiseOfRecords {
 public:
  explicit NoiseOfRecords(const scene::Lidar& lidar);
  /// Without air. Thresholds of the last few backgrounds and full scales are kept.
  const DetectorNoise& of(double background, double largest_signal);

 private:
  struct Known {
    double background = 0, full_scale = 0, threshold = 0, alarms = 0;
  };
  const scene::Lidar& lidar_;
  DetectorNoise noise_;
  std::vector<Known> known_;
  std::size_t oldest_ = 0;
};
DetectorNoise detector_noise(const scene::Lidar& lidar, double background, double largest_signal);

/// Probability that noise alone (background, air, electronics) brings a bin to `value` or more above its
/// background and air. photons: Poisson, or negative binomial about the air's speckle modes. linear:
/// Gaussian, or (not `gaussian`) avalanches as a gamma distribution of their variance m F and third cumulant
/// m F (2 F - 1), m carriers of gamma gains, beside the Gaussian floor. Within 40 % of drawn noise for
/// chances of 1e-3 to 5e-6 and 0.01 to 300 carriers a bin (test lidar_false_returns).
double noise_chance(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin, double value);
/// Chance that noise alone crosses a bin's threshold.
double alarm_chance(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin);
/// Whether a value above background and air is a signal's: its chance is at most bin_chance, and threshold_pe
/// is met.
bool reaches_threshold(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin, double value);
/// The noise as it is in one bin: its air is background, the threshold follows.
DetectorNoise noise_of_bin(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin);

/// Upper tail of the standard normal.
double normal_tail(double z);
/// P(count >= level) of Poisson background and signal with speckle modes (0: none). Sums below 4096 counts, Gaussian
/// with the same variance above.
double count_at_least(double level, double signal, double background, double modes);
/// Probability that a bin with that expected signal reaches background + threshold; photons: counts, linear: Gaussian.
/// Without air, or of one bin whose air is background.
double bin_detection(const scene::Lidar& lidar, const DetectorNoise& noise, double signal, double modes);
double bin_detection(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin, double signal,
                     double modes);

}  // namespace raycube::lidar
