// Extinction at 0.55 um against height: exponential between knots, linear where one end is 0 (LOWTRAN7's rule), 0
// outside.
#pragma once

#include <vector>

namespace raycube::atmos {

class HeightProfile {
 public:
  struct Knot {
    double height_km, extinction_per_km;
  };
  HeightProfile() = default;
  /// Heights ascend strictly, extinctions >= 0; Error(bug) otherwise.
  explicit HeightProfile(std::vector<Knot> knots);

  const std::vector<Knot>& knots() const { return knots_; }
  double extinction_per_km(double height_km) const;
  /// Optical depth between two heights, the exact integral.
  double depth(double low_km, double high_km) const;
  double total_depth() const;
  void scale(double factor);

 private:
  std::vector<Knot> knots_;
};

}  // namespace raycube::atmos
