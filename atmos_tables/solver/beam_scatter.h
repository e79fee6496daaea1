// Light scattered once from the beam, with the exact phase function along the scaled depth (TMS), and the
// small-angle correction of the higher orders in the aureole (IMS): Nakajima & Tanaka (1988), JQSRT 40, 51,
// eq. 22-25 and section 3.3.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "atmos_tables/solver/rays.h"

namespace raycube::atmos::solver {

/// How much light scattered once in each layer reaches a place along a ray, per unit phase function of the
/// layer: flux / (4 pi) omega / (1 - omega f) times the integral along the scaled depth (`exact`), or with
/// the truncated albedo. [place]: layers x rays.
std::vector<Eigen::MatrixXd> scatter_once(const Column& column, const ScaledColumn& scaled, const Rays& rays,
                                          const std::vector<Place>& places, bool exact);

/// Phase functions of all layers in one direction of scattering times those weights: the radiance scattered
/// once, for any number of angles.
class OnceScattered {
 public:
  /// exact: the phase functions of `layers` (their series, or phase_values where the column has them), not
  /// the truncated ones.
  OnceScattered(const Column& column, const ScaledColumn& scaled, bool exact,
                const std::vector<Eigen::MatrixXd>& weights);

  /// Radiance at every place along a ray at a cosine of the scattering angle.
  void add(Eigen::Index ray, double cos_angle, Eigen::Ref<Eigen::VectorXd> radiance) const;

 private:
  const Column& column_;
  const std::vector<Eigen::MatrixXd>& weights_;
  bool tabulated_;
  std::vector<std::vector<std::vector<double>>> series_;  ///< [place][ray] moments of the weighted sum
};

/// IMS term at one place, to be subtracted from downward radiance. 0 beyond 20 degrees of the beam (S4.6:
/// small-angle term) and where nothing was truncated above the place.
class Aureole {
 public:
  Aureole(const Column& column, const ScaledColumn& scaled, const Place& place);
  double excess(double cosine, double cos_angle) const;

 private:
  double flux_ = 0, beam_cosine_ = 1, depth_ = 0, peak_albedo_ = 0;
  std::vector<double> spike_;  ///< empty: no excess
};

}  // namespace raycube::atmos::solver
