// How a map of scores finds targets that are known: receiver operating characteristics (docs/analysis.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/analysis/regions.h"

namespace raycube::analysis {

/// Which pixels can be false alarms.
enum class FalseAlarms {
  outside_area,  ///< outside the rectangle around all targets, wider by the buffer: where targets are not known exactly
  exact          ///< outside each target's pixels, wider by the buffer: where they are
};

/// Which share the least one is of. A target of 0.155 m2 fills at most 15.5 % of a pixel of 1 m2.
enum class ShareOf {
  pixel,  ///< how much of the pixel the target fills
  target  ///< how much of the target lies in the pixel
};

struct RocOptions {
  FalseAlarms false_alarms = FalseAlarms::exact;
  int buffer_px = 1;
  ShareOf share_of = ShareOf::pixel;
  double least_share = 0;   ///< target pixels of less are neither found nor false alarms
  bool per_target = false;  ///< a target is found when its best pixel is; else each pixel counts
  bool lower_is_target = false;
  int bootstrap = 1000;
  std::uint64_t seed = 1;
};

struct RocPoint {
  double threshold = 0, false_alarm_rate = 0, detection_rate = 0;
};

struct Roc {
  std::vector<RocPoint> point;  ///< thresholds from strictest to none; scores that are alike come together
  std::uint64_t positives = 0, negatives = 0, targets = 0;
  std::uint64_t not_scored = 0;                ///< positives without a score, which are not found at any threshold
  double area = 0;                             ///< under the curve
  double before_first_false_alarm = 0;         ///< detection rate above the highest negative
  double interval_low = 0, interval_high = 0;  ///< of that, 95 %: targets drawn again with their pixels, negatives kept
};

/// Targets of an image: pixels that touch, by an edge or a corner, and have a share of target are one. Their numbers
/// are from 1, in the order of their first pixels; 0: none.
std::vector<std::uint32_t> number_targets(const std::vector<double>& share, std::int64_t samples, std::int64_t lines);

/// score: not a number: no false alarm, and no target found. share: of each pixel's area, 0 to 1; not a number: the
/// pixel takes no part. Throws Error(input) where a share is above 1, or no target or no negative is left.
Roc roc(const std::vector<double>& score, const std::vector<double>& share, std::int64_t samples, std::int64_t lines,
        const RocOptions& options);

}  // namespace raycube::analysis
