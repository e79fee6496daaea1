// Parts of detection that know no files and no plan: expectations of a row in photo-electrons, noise, thresholds,
// probabilities.
#pragma once

#include <vector>

#include "host/lidar/detection.h"
#include "scene_compiler/lidar_spec.h"

namespace raycube::lidar {

/// Expected photo-electrons of one row.
struct RowExpectation {
  std::vector<double> signal;  ///< [bin], quantum efficiency included
  double background = 0;       ///< a bin: background light and dark counts
};

/// What a record's noise is made of, primary photo-electrons.
struct DetectorNoise {
  double background = 0;  ///< mean a bin
  double excess = 1;      ///< variance of a bin per expected photo-electron: F (linear), 1 (photons, geiger)
  double floor = 0;       ///< rms of readout and digitiser, a bin
  std::vector<double> response{
      1};                 ///< shares of neighbouring bins, middle one in the middle; white noise of `floor` comes after
  double threshold = 0;   ///< above the background, where there is no air; a peak that reaches it counts
  double bin_chance = 0;  ///< of noise reaching a bin's threshold, air or not
  bool gaussian = true;   ///< linear: the noise counts as Gaussian (threshold_sigma); else with its skewness
                          ///< (false_returns)
  double full_scale = 0;  ///< photo-electrons; 0: none
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
/// Convolution; what leaves the row is lost.
std::vector<double> convolve(const std::vector<double>& row, const std::vector<double>& taps);

/// Standard deviation of an echo of a flat target as recorded: pulse and electronics, s.
double recorded_sigma_s(const scene::Lidar& lidar);

/// Noise of photons and linear detectors for a row whose largest expectation (signal alone) is given.
/// Thresholds: what noise reaches in a bin no more often than bin_chance, false_returns over the bins of a
/// record or a Gaussian's tail beyond threshold_sigma, and at least threshold_pe (linear: above the
/// background; photons: counts in all). Few counts are no Gaussian: 4 sigma of 0.1 counts would be met by
/// chance once in 200 bins, so photons are judged by Poisson's law and, with false_returns, avalanches with
/// their skewness.
DetectorNoise detector_noise(const scene::Lidar& lidar, double background, double largest_signal);

/// Probability that noise alone (background, air, electronics) brings a bin to `value` or more above its
/// background and air. photons: Poisson, or negative binomial about the air's speckle modes. linear:
/// Gaussian, or (not `gaussian`) avalanches as a gamma distribution of their variance m F and third cumulant
/// m F (2 F - 1), m carriers of gamma gains, beside the Gaussian floor. Within 40 % of drawn noise for
/// chances of 1e-3 to 5e-6 and 0.01 to 300 carriers a bin (test lidar_false_returns).
double noise_chance(const scene::Lidar& lidar, const DetectorNoise& noise, std::size_t bin, double value);
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
double bin_detection(const scene::Lidar& lidar, const DetectorNoise& noise, double signal, double modes);

}  // namespace raycube::lidar
