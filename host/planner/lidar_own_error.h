// What is known of a LIDAR run's error, whoever chose its sub-rays (S60).
//
// Where the planner made a trial, that. Where the file gives the sub-rays, pulses picked by hash are fired as the
// run fires them (a) and several times on other patterns (r, s), each at least as fine: E[(a - r)(a - s)] =
// E[(a - truth)^2] for r and s without bias and independent of each other and of a, however coarse they are.
#pragma once

#include <string>

#include "host/lidar/lidar_plan.h"
#include "host/planner/lidar_trial.h"
#include "host/render/lidar_renderer.h"

namespace raycube::planner {

/// Of the expected waveforms, as lidar_trial.h has it; of surfaces alone. `total` is a bound: two standard errors
/// above the mean square, over at least eight draws (pulses; of fewer pulses, and of a receiver, whose pattern is
/// one for all its pixels and pulses, patterns). Of a receiver's array its middle 8 x 8 pixels.
struct LidarOwnError {
  double total = -1, likely = -1;  ///< below 0: not known
  double tolerance = 0.01;
  std::string from;  ///< how it is known, or why not
  bool known() const { return total >= 0; }
  bool kept() const { return known() && total <= tolerance; }
};

/// Fires only where the decision was not made by a trial: 3e5 first rays or a hundredth of the survey's, and eight
/// draws whatever they cost.
LidarOwnError own_error(render::LidarRenderer& renderer, const lidar::LidarPlan& plan, const LidarDecision& decision);

/// One line: total against tolerance, how it is known.
std::string own_error_text(const LidarOwnError& error);
/// The same as a JSON object.
std::string own_error_json(const LidarOwnError& error);

}  // namespace raycube::planner
