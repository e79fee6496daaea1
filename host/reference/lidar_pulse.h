// The pulse in time, integrated over bins from its own formula; the plan's tap table is not used.
#pragma once

#include <vector>

#include "scene_compiler/lidar_spec.h"

namespace raycube::reference {

class LidarPulseShape {
 public:
  explicit LidarPulseShape(const scene::LidarPulse& pulse);

  /// Share of the energy between two times (s) after the pulse's t = 0. Half open at the end: an impulse at `from_s`
  /// counts. Relative error 1e-13 in the Gaussian's tails too (differences of erfc on one side).
  double share(double from_s, double to_s) const;
  /// Nothing above 1e-18 of the energy lies outside.
  double first_s() const { return first_s_; }
  double last_s() const { return last_s_; }

 private:
  double tabulated(double until_s) const;

  scene::PulseShape shape_;
  double sigma_s_ = 0, first_s_ = 0, last_s_ = 0;
  std::vector<double> time_s_, power_, cumulative_;
};

}  // namespace raycube::reference
