// Echoes in waveforms: which peaks are returns, and their time, area and width by one of three methods.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "host/lidar/detection.h"
#include "host/lidar/detector.h"
#include "host/lidar/gaussian_fit.h"

namespace raycube::lidar {

/// Returns of a waveform in photo-electrons per bin (background included), in order of time, at most max_returns (the
/// strongest), numbered. A return is a maximum of the waveform smoothed over half the recorded pulse (not smoothed
/// where the noise is zero), with a bin above the threshold within the pulse's half width, parted from the next by a
/// dip of at least 3 standard deviations of the noise there (further apart than 4 of the pulse: 5, or below half of the
/// lower maximum), or of 5 without smoothing in the upper three quarters.
///   peak               parabola through the logarithms of the three bins about the maximum
///   constant_fraction  last crossing of fraction x maximum before it, plus what a flat target's echo takes from there
///                      to its centre
///                      (both: of returns that overlap, each is measured where fitted Gaussians of the others are taken
///                      off, and has its own Gaussian's width and area)
///   gaussian           sum of Gaussians integrated over the bins, least squares with the noise's weights
///                      (Levenberg-Marquardt); a component is added where the residuals ask for one (fall of chi^2 by
///                      more than 30), no narrower than the pulse and no wider than 3 of it. Width and area from the
///                      fit.
/// Times are those of the pulse's time 0 (zero_at): what a method finds of the pulse itself, a flat target's, is taken
/// off. Dips and residuals below the waveforms' own error are no echoes. Probabilities are left 0.
class EchoFinder {
 public:
  /// waveform_error: rms error of expected waveforms by their sub-rays, a share of them (LidarPlan::waveform_error).
  explicit EchoFinder(const scene::Lidar& lidar, double waveform_error = 0);
  /// Of the records to come: what surfaces are expected to send, photo-electrons a bin. The waveform's own error is of
  /// that light alone; of a record of which nothing is told it is of all. Must live until the next one is told.
  void expect_surfaces(std::span<const double> bins) { surfaces_ = bins; }
  /// Bins before `begin` and from `end` on hold the background alone; `echoes` are written anew.
  void operator()(std::span<const float> waveform_pe, std::size_t begin, std::size_t end, const DetectorNoise& noise,
                  std::vector<Echo>& echoes);
  /// By how much the method puts a flat target's strong echo late, s: taken off every time.
  double pulse_late_s();
  /// Most by which the pulse differs from the Gaussian nearest to it, a share of its peak.
  double pulse_shape_error() const { return pulse_shape_error_; }

 private:
  struct Peak {
    std::size_t at = 0, left = 0, right = 0;  ///< a maximum of the smoothed waveform, its bins [left, right)
  };
  struct Taps {
    double sigma_bins = 0;
    std::vector<double> taps;
    double white = 1, shot = 1;  ///< sums of squares: the taps' own, and after the electronics' response
  };
  Taps taps_of(double sigma_bins) const;
  double smooth_rms(std::size_t bin, double signal) const;
  void find_signal(std::size_t begin, std::size_t end);
  void find_peaks(std::size_t begin, std::size_t end);
  /// Standard deviation of a bin by sub-rays; seen: what is there, where nothing is told of surfaces.
  double ray_noise(std::size_t bin, double seen) const {
    return std::sqrt(per_light_ * std::max(0.0, surfaces_.empty() ? seen : surfaces_[bin]));
  }
  bool split_unsmoothed(std::size_t peak);
  void drop_lone_rays();
  bool is_steep(std::size_t at, int step) const;
  double crossing(std::size_t from, double level, int step) const;
  std::array<double, 2> vertex(std::size_t at) const;
  bool saturated(std::size_t left, std::size_t right) const;
  double highest(std::size_t left, std::size_t right) const;
  double width_bins(std::size_t at) const;
  double position_of(std::size_t at) const;
  Echo echo_at(double position_bins, double peak_pe, double area_pe, double fwhm_bins, bool is_saturated) const;
  Echo measure(const Peak& peak) const;
  void measure_group(std::size_t first_peak, std::size_t last_peak, std::vector<Echo>& out);
  void show_without_others(std::size_t first_peak, std::size_t last_peak, std::size_t own);
  /// A pulse of area 1 as recorded, and its time 0 in bins.
  struct PulseRow {
    std::vector<double> share;
    double zero = 0;
  };
  struct Late {
    double bins = 0, area = 1;  ///< the fit's place behind the pulse's time 0; its area over the pulse's
  };
  void calibrate();
  double own_shape_error() const;
  GaussianEcho nearest(const PulseRow& row, double area, double floor, double excess);
  const Late& late_of_fit(double area, double floor, double excess);
  /// Bins of peaks that are fitted together, their noise, and chi^2.
  struct Group {
    std::size_t first = 0, last = 0;
    double floor = 0, last_floor = 0, excess = 0, chi = 0;  ///< last_floor: of the last fit, which looks for no more
  };
  Group fit_peaks(std::size_t first_peak, std::size_t last_peak);
  void fit_group(std::size_t first_peak, std::size_t last_peak, std::vector<Echo>& out);
  bool is_of_one_slope(const Peak& peak) const;
  bool add_component(std::size_t first, std::size_t last, double& chi, double floor, double excess);
  void split(const GaussianEcho& one, std::vector<GaussianEcho>& two) const;
  std::ptrdiff_t wide(const std::vector<GaussianEcho>& echoes) const;

  static constexpr std::size_t kMostPeaks = 6;  ///< of a group fitted together

  const scene::Lidar& lidar_;
  double sigma_bins_, waveform_error_;
  std::span<const double> surfaces_;  ///< empty: not told
  double per_light_ = 0;              ///< variance of a bin by sub-rays, over its light
  double light_ = 0;                  ///< of surfaces, in the record
  double pulse_shape_error_ = 0;
  bool gaussian_pulse_ = true;        ///< of which every method finds the middle
  std::vector<PulseRow> pulse_rows_;  ///< at some phases; empty: a Gaussian
  std::array<double, 2> late_{};      ///< by peak and constant_fraction, bins: not smoothed, smoothed
  struct KnownLate {
    double area = 0, floor = 0, excess = 0;
    Late late;
  };
  std::vector<KnownLate> known_late_;
  std::size_t oldest_late_ = 0;
  GaussianFit pulse_fit_;
  Taps smoothing_, none_;
  std::vector<double> pulse_taps_;  ///< of the recorded pulse's shape
  const DetectorNoise* noise_ = nullptr;
  const Taps* used_ = nullptr;
  bool noisy_ = false;
  std::array<std::ptrdiff_t, 2> touched_{};  ///< bins of raw_ and smooth_ that may not be 0: [0] to before [1]
  std::vector<double> raw_, smooth_, residual_, residual_smooth_;
  const std::vector<double>* shown_ = nullptr;  ///< what is measured: smooth_, or of it what others leave
  std::vector<double> alone_;
  std::vector<GaussianEcho> bells_;         ///< of peaks measured together
  std::vector<std::size_t> signal_;         ///< bins that reach their threshold
  std::vector<std::size_t> kept_, valley_;  ///< valley_[i]: lowest bin between kept_[i - 1] and kept_[i]
  std::vector<Peak> peaks_;
  std::vector<GaussianEcho> fitted_, trial_;
  GaussianFit fit_;
};
std::vector<Echo> find_echoes(const scene::Lidar& lidar, const std::vector<float>& waveform_pe,
                              const DetectorNoise& noise);

/// Echoes of a Geiger detector's time tags: clusters no gap of which exceeds the recorded pulse's half width (at least
/// a bin), of at least threshold_pe events; time = mean, area = events, width = 2.355 x standard deviation (0 for one
/// event).
std::vector<Echo> cluster_tags(const scene::Lidar& lidar, const std::vector<Photon>& tags);

/// Keeps the strongest max_returns, numbers them in order of time and sets ranges.
void number_echoes(const scene::Lidar& lidar, std::vector<Echo>& echoes);

}  // namespace raycube::lidar
