// Errors of a setting in every band, and what the errors of two settings make together.
//
// The band in which samples err most (near infrared, where leaves are bright) is seldom the one in which the sky does
// (blue): the tolerance is of the worst band of all errors together, not of the worst bands' errors together.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::planner {

/// Relative errors, 1, >= 0, of each band (as many of both); a single entry stands for any number of bands.
struct BandErrors {
  std::vector<double> estimate;  ///< roots of the mean squares found
  std::vector<double> bound;     ///< >= estimate: with one standard error of the mean square on top

  double worst_estimate() const;  ///< of the band where it is largest; 0 of no bands
  double worst_bound() const;
};

/// Correlation of what is not known of the errors of samples and of sky directions. They are told by renders of their
/// own, but on the same drawn pixels: -0.2 (streets of boxes), 0.05 (park) and 0.3 (crowded wood) from run to run.
inline constexpr double kTogether = 0.25;

/// Standard errors of the sum that its bound has on top. The cheapest of many settings is likelier than any one of them
/// to owe its place to a lucky draw of pixels: docs/accuracy.md says how well this holds.
inline constexpr double kSure = 2;

/// Mean squares of one level in every band, ready for sums.
class BandSquares {
 public:
  explicit BandSquares(const BandErrors& errors);

  /// Worst band's e1^2 + e2^2 + kSure sqrt(d1^2 + d2^2 + 2 kTogether d1 d2): the mean squares of errors that are
  /// independent add, and so do the variances of what is not known of them; e: estimate, d = bound^2 - estimate^2.
  /// Bands are looked at from `first_band` on, which becomes the worst; a sum past `enough` is told as soon as one is
  /// found.
  /// Throws Error(bug) where both have several bands and not as many.
  double with(const BandSquares& other, double enough, std::size_t& first_band) const;

 private:
  std::vector<double> square_, deviation_;
};

/// Bound of two independent errors together, of the worst band.
double bound_together(const BandErrors& one, const BandErrors& other);

}  // namespace raycube::planner
