// Lines of a scan, as surveyors' files know them: which way the beam goes, and where a line ends.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "scene_compiler/lidar_spec.h"

namespace raycube::lidar {

/// Of pulses one after the other, by the scanner's own phase: how the platform turns does not matter.
class ScanLine {
 public:
  explicit ScanLine(const scene::Lidar& lidar) : lidar_(lidar) {}

  /// Whether there are lines at all: a fixed beam and a cone have none.
  bool scans() const {
    return lidar_.scan.pattern != scene::ScanPattern::fixed && lidar_.scan.pattern != scene::ScanPattern::palmer;
  }

  /// The next pulse; whether the one before it ended a line: an oscillating mirror turned back, any other begins anew.
  bool next(std::int64_t pulse) {
    const std::int64_t line = line_of(pulse);
    const bool ended = line_ && line != *line_;
    line_ = line;
    return ended;
  }
  /// Whether the beam goes to the right as it crosses the flight: an oscillating mirror's every other line, and all
  /// lines of others.
  bool to_right() const {
    return scans() && (lidar_.scan.pattern != scene::ScanPattern::oscillating || line_.value_or(0) % 2 == 0);
  }

 private:
  std::int64_t line_of(std::int64_t pulse) const {
    const double cycles = lidar_.scan.scan_rate_hz * static_cast<double>(pulse) / lidar_.prf_hz;
    switch (lidar_.scan.pattern) {
      case scene::ScanPattern::line:
        return static_cast<std::int64_t>(std::floor(cycles));
      case scene::ScanPattern::oscillating:  // from left to right about whole cycles
        return static_cast<std::int64_t>(std::floor(2 * cycles + 0.5));
      case scene::ScanPattern::rotating:  // fired about the nadir, at whole cycles
        return std::llround(cycles);
      case scene::ScanPattern::raster:
        return pulse / std::max(1, lidar_.scan.columns);
      default:
        return 0;
    }
  }

  const scene::Lidar& lidar_;
  std::optional<std::int64_t> line_;
};

}  // namespace raycube::lidar
