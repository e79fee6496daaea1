// Detectors of targets and anomalies (docs/analysis.md). With x a pixel, m and C mean and covariance of the background,
// R its mean of x x', s a target's spectrum, d = s - m, y = x - m:
//   mf          matched filter                  d'C^-1 y / d'C^-1 d            1 for a whole pixel of target
//   ace         adaptive coherence estimator    (d'C^-1 y)^2 / (d'C^-1 d  y'C^-1 y)        0 to 1
//   ace_signed  the same with the sign of d'C^-1 y                                         -1 to 1
//   cem         constrained energy minimisation s'R^-1 x / s'R^-1 s            1 for a whole pixel of target
//   sam         spectral angle mapper           acos(x's / |x| |s|), rad       0 for the target's own direction
//   rx          anomaly (Reed & Yu 1990)        y'C^-1 y                       chi-squared of as many degrees as bands
// Kraut, Scharf & McWhorter, IEEE Trans. Signal Process. 49 (2001), for ace; Harsanyi (1993) for cem; Kruse et al.
// (1993) for sam.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/analysis/dense_sums.h"
#include "host/analysis/moments.h"
#include "host/analysis/spectra.h"

namespace raycube::analysis {

/// Names of all, in the order above.
const std::vector<std::string>& detector_names();

/// (1 - share) M + share trace(M) / n I: what makes a matrix of few pixels invertible.
Eigen::MatrixXd shrunk(const Eigen::MatrixXd& symmetric, double share);

class Detection {
 public:
  /// detectors: of detector_names(). Throws Error(input): none of these names, no target for one that needs it, a
  /// background that cannot be inverted, a target that is the background's mean.
  Detection(const std::vector<std::string>& detectors, std::vector<NamedSpectrum> targets, const Moments& background,
            double shrink);

  /// "ace lime", "rx": target by target.
  const std::vector<std::string>& layers() const { return layers_; }
  /// [pixel][layer]; not a number where the pixel does not count, and sam of one that is zero. A pixel that is the
  /// background's mean has ace 0.
  void score(const Pixels& pixels, std::vector<double>& out) const;

 private:
  struct Target {
    Eigen::VectorXd spectrum, matched, constrained;  ///< s, C^-1 d, R^-1 s / s'R^-1 s
    double own = 0, length = 0;                      ///< d'C^-1 d, |s|
  };
  double score_of(const std::string& detector, const Target& target, const double* x, const double* y,
                  double norm) const;

  std::vector<std::string> detectors_, layers_;
  std::vector<Target> targets_;
  Eigen::VectorXd mean_;
  std::optional<InverseNorm> whitened_;  ///< where a detector asks for y'C^-1 y
};

}  // namespace raycube::analysis
