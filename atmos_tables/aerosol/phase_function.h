// Phase function of one substance at one wavelength: a mixture of tabulated shapes, Henyey-Greenstein, or Legendre
// moments.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "atmos_tables/aerosol/phase_shape.h"

namespace raycube::atmos {

/// Integral over the sphere 4 pi. Immutable; copies share their shapes.
class PhaseFunction {
 public:
  struct Part {
    double weight = 1;
    std::shared_ptr<const PhaseShape> shape;
  };
  /// Weights >= 0 that sum to 1 (checked to 1e-9; Error(bug)).
  explicit PhaseFunction(std::vector<Part> parts);
  /// (1 - g^2) / (1 + g^2 - 2 g cos)^1.5, moments g^k; |g| < 1. Up to 2.6 times too low at 180 degrees.
  static PhaseFunction henyey_greenstein(double g);

  /// P = sum (2 k + 1) chi_k P_k(cos); chi_0 = 1 (Error(bug)); moments that are not given are 0. Where the sum is below
  /// 0, as few or rounded moments leave it, the value is 0.
  static PhaseFunction of_moments(std::vector<double> moments);

  /// Weighted sum of two mixtures of shapes, weights as above. Error(bug) when one of them is none.
  static PhaseFunction mixture(const PhaseFunction& a, double weight_a, const PhaseFunction& b, double weight_b);

  double value(double cos_angle) const;
  /// chi_k = 1/2 int P P_k dmu for k = 0..last. chi_0 = 1, chi_1 = asymmetry().
  std::vector<double> moments(std::size_t last) const;
  /// Mean cosine of this very function, which may differ from the optics table's (aerosol_column.h).
  double asymmetry() const;

 private:
  PhaseFunction() = default;
  std::vector<Part> parts_;      ///< empty for the others
  std::vector<double> moments_;  ///< empty for Henyey-Greenstein
  double g_ = 0;
};

}  // namespace raycube::atmos
