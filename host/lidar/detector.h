// Parts of detection that know no files and no plan: expectations of a row in photo-electrons, noise, thresholds, probabilities.
#pragma once

#include <vector>

#include "host/lidar/detection.h"
#include "scene_compiler/lidar_spec.h"

namespace raycube::lidar {

/// Expected photo-electrons of one row.
struct RowExpectation {
  std::vector<double> signal;      ///< [bin], quantum efficiency included
  double background = 0;           ///< a bin: background light and dark counts
};

/// What a record's noise is made of, primary photo-electrons.
struct DetectorNoise {
  double background = 0;           ///< mean a bin
  double excess = 1;               ///< variance of a bin per expected photo-electron: F (linear), 1 (photons, geiger)
  double floor = 0;                ///< rms of readout and digitiser, a bin
  std::vector<double> response{1}; ///< shares of neighbouring bins, middle one in the middle; white noise of `floor` comes after
  double threshold = 0;            ///< above the background; a peak that reaches it counts
  double full_scale = 0;           ///< photo-electrons; 0: none

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

/// Noise of photons and linear detectors for a row whose largest expectation (signal alone) is given. Thresholds: linear, threshold_sigma
/// standard deviations and at least threshold_pe above the background; photons, the count that noise exceeds no more often than a Gaussian
/// exceeds threshold_sigma (few counts are no Gaussian: 4 sigma of 0.1 counts would be met by chance once in 200 bins), and at least threshold_pe counts.
DetectorNoise detector_noise(const scene::Lidar& lidar, double background, double largest_signal);

/// Upper tail of the standard normal.
double normal_tail(double z);
/// P(count >= level) of Poisson background and signal with speckle modes (0: none). Sums below 4096 counts, Gaussian with the same variance above.
double count_at_least(double level, double signal, double background, double modes);
/// Probability that a bin with that expected signal reaches background + threshold; photons: counts, linear: Gaussian.
double bin_detection(const scene::Lidar& lidar, const DetectorNoise& noise, double signal, double modes);

}  // namespace raycube::lidar
