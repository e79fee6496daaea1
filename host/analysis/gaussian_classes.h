// Classes by Gaussian maximum likelihood, and how a map of classes agrees with the truth.
#pragma once

#include <string>
#include <vector>

#include "host/analysis/dense_sums.h"
#include "host/analysis/moments.h"
#include "host/analysis/regions.h"

namespace raycube::analysis {

/// g_k(x) = ln p_k - ln|C_k| / 2 - (x - m_k)' C_k^-1 (x - m_k) / 2; the class is the largest.
class GaussianClasses {
 public:
  /// shrink: of each covariance (detection.h, shrunk). prior: of each class; empty: all alike. Throws Error(input) that
  /// names the class whose covariance cannot be inverted, and how many pixels it has.
  GaussianClasses(const std::vector<std::string>& names, const std::vector<Moments>& classes,
                  const std::vector<double>& prior, double shrink);

  std::size_t classes() const { return class_.size(); }
  /// [pixel]: number of the class, from 1; 0 where the pixel does not count, or no class has a probability density
  /// above what doubles tell.
  void classify(const Pixels& pixels, std::vector<double>& out) const;

 private:
  struct Class {
    Eigen::VectorXd mean;
    InverseNorm whitened;
    double constant = 0;  ///< ln p - ln|C| / 2
  };
  std::vector<Class> class_;
};

/// Rows: the truth; columns: what the map says, the last one nothing.
struct Confusion {
  std::vector<std::string> names;
  std::vector<std::vector<std::uint64_t>> count;

  std::uint64_t total() const;
  double accuracy() const;                             ///< share of pixels whose class is right
  double kappa() const;                                ///< Cohen (1960); not a number where chance alone is right
  std::vector<double> producer() const, user() const;  ///< of what is so, of what is said to be so; NaN where none
};

/// Counts pixels of truth regions by what a map says of them; a map's class and a truth of one name are the same.
/// Throws Error(input) where a truth is no class of the map.
class ConfusionCount {
 public:
  ConfusionCount(const std::vector<std::string>& classes, const std::vector<Region>& truth);
  /// class of each pixel of a stretch, from 1; pixels that do not count are left out. From one thread at a time for one
  /// part.
  void add(std::size_t part, const Pixels& pixels, const std::vector<double>& found);
  Confusion result() const;

 private:
  std::vector<std::string> names_;
  const std::vector<Region>& truth_;
  std::vector<std::size_t> row_;
  std::vector<std::vector<std::vector<std::uint64_t>>> part_;
};

}  // namespace raycube::analysis
