// Lines of a scan, as surveyors' files know them: which way the beam goes, and where a line ends.
#pragma once

#include <optional>

#include "scene_compiler/lidar_spec.h"

namespace raycube::lidar {

/// Of pulses one after the other.
class ScanLine {
 public:
  explicit ScanLine(scene::ScanPattern pattern) : pattern_(pattern) {}

  /// Whether there are lines at all: a fixed beam and a cone have none.
  bool scans() const { return pattern_ != scene::ScanPattern::fixed && pattern_ != scene::ScanPattern::palmer; }

  /// The next pulse's angle across, right positive; whether the one before it ended a line: an oscillating mirror
  /// turned back, any other jumped back.
  bool next(double angle_rad) {
    if (!scans()) return false;
    const std::optional<double> before = angle_rad_;
    angle_rad_ = angle_rad;
    if (!before || angle_rad == *before) return false;
    const bool right = angle_rad > *before;
    if (pattern_ != scene::ScanPattern::oscillating) {
      right_ = true;
      return !right;
    }
    const bool turned = known_ && right != right_;
    right_ = right, known_ = true;
    return turned;
  }
  bool to_right() const { return scans() && right_; }

 private:
  scene::ScanPattern pattern_;
  std::optional<double> angle_rad_;
  bool right_ = true, known_ = false;
};

}  // namespace raycube::lidar
