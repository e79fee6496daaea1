// Mean and covariance of a cube's pixels.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/cube.h"

namespace raycube::analysis {

/// Sums of pixels about their own mean, in double: stretches of pixels are centred on their mean and squared, and put
/// together after Chan, Golub & LeVeque, "Updating formulae and a pairwise algorithm for computing sample variances"
/// (1979), so that nothing is lost where a band's mean is far greater than its spread.
class Moments {
 public:
  explicit Moments(std::size_t bands = 0);
  /// Pixels, one after the other: [pixel][bands].
  void add(const double* pixels, std::size_t count);
  void merge(const Moments& other);

  std::size_t bands() const { return static_cast<std::size_t>(mean_.size()); }
  std::uint64_t count() const { return count_; }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// 1 / (N - 1) sum (x - mean) (x - mean)'; zero below two pixels.
  Eigen::MatrixXd covariance() const;
  /// 1 / N sum x x', about zero.
  Eigen::MatrixXd correlation() const;

 private:
  std::uint64_t count_ = 0;
  Eigen::VectorXd mean_;
  std::vector<double> square_;  ///< add_squares of centred pixels
  std::vector<double> block_;   ///< centred and padded
};

/// Says which pixels of a stretch take part; called in any order.
using Chooses = std::function<bool(std::int64_t line, std::int64_t sample)>;

/// Of all pixels that count and are chosen (empty: all), the same bits on any number of threads.
Moments moments_of(const Cube& cube, const Pass& pass, const Chooses& chooses = {});

/// W = L^-1 of M = L L', row-major, for InverseNorm, and M^-1.
struct Inverse {
  std::vector<double> lower;
  Eigen::MatrixXd whole;
  double log_determinant = 0;  ///< of M
};
/// Throws Error(input) that names `what` where M is not positive or its condition number, of bands with variance 1, is
/// past 1e12 ("fewer pixels than bands, or bands that are constant or repeat each other").
Inverse invert(const Eigen::MatrixXd& symmetric, const std::string& what);

}  // namespace raycube::analysis
