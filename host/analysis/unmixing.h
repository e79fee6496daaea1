// Unmixing: a pixel as a sum of endmembers, x = E a + n, least squares (docs/analysis.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/cube.h"
#include "host/analysis/spectra.h"

namespace raycube::analysis {

/// What the shares keep.
enum class Constraint {
  full,  ///< sum 1, none below 0: fully constrained least squares, exact
  sum,   ///< sum 1
  none
};
Constraint parse_constraint(const std::string& text);

/// At most so many endmembers: each set of them that a pixel may be made of has a solution of its own.
inline constexpr std::size_t kMostEndmembers = 12;

class Unmixing {
 public:
  /// Throws Error(input): fewer than 2 endmembers or more than kMostEndmembers, more than bands + 1 (bands without a
  /// constraint), or endmembers of which one is a mixture of others to 1e-10 of their size.
  Unmixing(const std::vector<NamedSpectrum>& endmembers, Constraint constraint);

  std::size_t endmembers() const { return static_cast<std::size_t>(spectra_.cols()); }
  /// Shares of one pixel, and the root mean square over its bands of what they leave.
  double solve(const double* pixel, double* share) const;
  /// [pixel][endmembers() + 1]: shares, then what they leave; not a number where the pixel does not count.
  void solve(const Pixels& pixels, std::vector<double>& out) const;

 private:
  /// Of a set of endmembers: their best shares of z are `times` z + `plus`, the others' 0.
  struct Support {
    std::vector<int> member;
    Eigen::MatrixXd times;
    Eigen::VectorXd plus;
  };
  const Support& support(std::uint32_t set) const { return supports_[set]; }
  Support make_support(std::uint32_t set) const;
  std::uint32_t constrained_set(const Eigen::VectorXd& z, Eigen::VectorXd& share) const;

  Constraint constraint_;
  Eigen::MatrixXd spectra_;            ///< [band][endmember]
  Eigen::VectorXd from_;               ///< what is taken off pixels and endmembers first
  Eigen::MatrixXd across_, triangle_;  ///< E - from_ = across_ triangle_, columns of across_ orthonormal
  std::vector<Support> supports_;      ///< [bits of the set]
};

}  // namespace raycube::analysis
