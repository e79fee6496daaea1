// Echoes in waveforms: which peaks are returns, and their time, area and width by one of three methods.
#pragma once

#include <array>
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
/// lower maximum).
///   peak               parabola through the logarithms of the three bins about the maximum
///   constant_fraction  first crossing of fraction x maximum, plus what a flat target's echo takes from there to its
///                      centre
///   gaussian           sum of Gaussians integrated over the bins, least squares with the noise's weights
///                      (Levenberg-Marquardt); a component is added where the residuals ask for one (fall of chi^2 by
///                      more than 30), no narrower than the pulse and no wider than 3 of it. Width and area from the
///                      fit.
/// Probabilities are left 0.
class EchoFinder {
 public:
  explicit EchoFinder(const scene::Lidar& lidar);
  /// Bins before `begin` and from `end` on hold the background alone; `echoes` are written anew.
  void operator()(std::span<const float> waveform_pe, std::size_t begin, std::size_t end, const DetectorNoise& noise,
                  std::vector<Echo>& echoes);

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
  double crossing(const Peak& peak, double level, int step) const;
  std::array<double, 2> vertex(std::size_t at) const;
  bool saturated(std::size_t left, std::size_t right) const;
  double highest(std::size_t left, std::size_t right) const;
  double width_bins(const Peak& peak) const;
  Echo echo_at(double position_bins, double peak_pe, double area_pe, double fwhm_bins, bool is_saturated) const;
  Echo measure(const Peak& peak) const;
  void fit_group(std::size_t first_peak, std::size_t last_peak, std::vector<Echo>& out);
  bool add_component(std::size_t first, std::size_t last, double& chi, double floor, double excess);
  void split(const GaussianEcho& one, std::vector<GaussianEcho>& two) const;
  std::ptrdiff_t wide(const std::vector<GaussianEcho>& echoes) const;

  const scene::Lidar& lidar_;
  double sigma_bins_;
  Taps smoothing_, none_;
  std::vector<double> pulse_taps_;  ///< of the recorded pulse's shape
  const DetectorNoise* noise_ = nullptr;
  const Taps* used_ = nullptr;
  bool noisy_ = false;
  std::array<std::ptrdiff_t, 2> touched_{};  ///< bins of raw_ and smooth_ that may not be 0: [0] to before [1]
  std::vector<double> raw_, smooth_, residual_, residual_smooth_;
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
