// A waveform as a sum of Gaussian echoes integrated over bins.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace raycube::lidar {

/// Position and sigma in bins (position 0: start of bin 0 of the data), area in the data's unit.
struct GaussianEcho {
  double area = 0, position = 0, sigma = 1;
  bool operator==(const GaussianEcho&) const = default;
};

/// Expected value of a bin.
double gaussian_bin(const GaussianEcho& echo, double bin);

/// Expected values of a window's bins, and how they change with each echo's three parameters: area, position, log
/// sigma. Rows are padded with zeros.
class EchoModel {
 public:
  /// Bins first .. first + bins - 1 of the data.
  void prepare(std::size_t first, std::size_t bins, std::size_t echoes);
  void evaluate(std::span<const GaussianEcho> echoes);
  const double* expected() const { return expected_.data(); }
  const double* slopes(std::size_t echo) const { return slope_.data() + 3 * echo * padded_; }
  std::size_t padded() const { return padded_; }  ///< length of a row
  /// Bins that an echo reaches: [0] to before [1].
  const std::array<std::size_t, 2>& reach(std::size_t echo) const { return reach_[echo]; }

 private:
  std::size_t first_ = 0, bins_ = 0, padded_ = 0;
  std::vector<double> expected_, slope_;  ///< [bin]; [echo][parameter][bin]
  std::vector<std::array<std::size_t, 2>> reach_;
  std::vector<double> tail_, density_;  ///< at the edges of an echo's bins
};

/// Fits, one after the other: memory is kept from one to the next.
class GaussianFit {
 public:
  static constexpr std::size_t kMostEchoes = 12;

  /// Least squares over data[first..last) with variance = floor^2 + slope * (model + 0.3), re-weighted with the model,
  /// which makes it maximum likelihood for counts; floor = slope = 0: every bin as if known to 1 % of the highest.
  /// Levenberg-Marquardt (Marquardt 1963) on (area, position, log sigma). Areas stay positive, sigma above 0.02 bins,
  /// positions within the window. Twice weighted, chi^2 within about 1 of its least: enough to say whether echoes are
  /// missing. Returns chi^2; echoes, kMostEchoes at most, hold the solution.
  double roughly(std::span<const double> data, std::size_t first, std::size_t last, double floor, double slope,
                 std::vector<GaussianEcho>& echoes);
  /// The same data by other echoes, weighted as before: chi^2 within about 3 of its least.
  double again(std::vector<GaussianEcho>& echoes);
  /// Weights by the echoes of the last call; returns their chi^2.
  double weigh_anew(double floor, double slope);
  /// The same data again, weighted once more: the solution, to a thirtieth of its standard deviation (without noise: to
  /// 1e-6 of the highest bin).
  double finish(double floor, double slope, std::vector<GaussianEcho>& echoes);

 private:
  void begin(std::span<const double> data, std::size_t first, std::size_t last);
  void model(const std::vector<GaussianEcho>& echoes);
  void weigh(double floor, double slope);
  double descend(double enough, std::vector<GaussianEcho>& echoes);
  double chi_squared(const EchoModel& model) const;
  bool step(double damping, const std::vector<GaussianEcho>& from);
  double promised(std::size_t echoes) const;
  void normal_equations(std::size_t echoes);

  std::size_t first_ = 0, last_ = 0;
  double damping_ = 0;                            ///< of the next step
  std::vector<double> data_, weight_, weighted_;  ///< of the window's bins; weight times what the model leaves
  EchoModel model_, trial_model_;
  std::vector<GaussianEcho> trial_, solved_;                               ///< solved_: what model_ holds
  std::array<double, 9 * kMostEchoes * kMostEchoes> normal_{}, damped_{};  ///< upper halves, rows of whole lanes
  std::array<double, 3 * kMostEchoes> gradient_{}, change_{};
};

}  // namespace raycube::lidar
