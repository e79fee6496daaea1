// Sub-rays of a LIDAR for a tolerance, by a trial of a few pulses.
//
// Error of a LIDAR here: root of the summed squared differences of the expected waveforms (all pulses, pixels, lines
// and bins) from the converged ones, over the root of the summed squares of those.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "host/planner/planner.h"
#include "host/render/lidar_renderer.h"

namespace raycube::planner {

struct LidarDecision {
  int subrays = 256;
  bool given = false, estimated = false;
  double error = -1, less_error = -1;  ///< bounds: of the sub-rays chosen and of the level before
  double likely = -1;                  ///< as `error`, without the margin that makes it a bound
  double pulse_error = -1;             ///< of 95 in 100 pulses, each of its own waveforms; at least `likely`
  double tolerance = 0.01;
  bool within = true;
  std::size_t trial_pulses = 0;
  std::uint64_t trial_rays = 0, rays_per_pulse = 0;
  std::vector<std::string> notes;
};

/// Levels that are tried.
const std::vector<int>& subray_levels();

/// First rays of a pulse with so many sub-rays.
std::uint64_t rays_of_pulse(const lidar::LidarPlan& plan, int subrays);

/// The plan with another number of sub-rays.
void set_subrays(lidar::LidarPlan& plan, int subrays);

/// The fewest sub-rays whose error is inside the tolerance; those the file gives stay, and are tried only when
/// `estimate_given`.
LidarDecision decide_subrays(render::LidarRenderer& renderer, const lidar::LidarPlan& plan, double tolerance,
                             bool estimate_given);

/// What the file or the default says, without a trial.
LidarDecision subrays_as_given(const lidar::LidarPlan& plan, double tolerance);

std::vector<PlanLine> lidar_lines(const LidarDecision& decision, const lidar::LidarPlan& plan);
nlohmann::json lidar_decision_json(const LidarDecision& decision, const std::vector<PlanLine>& lines);

}  // namespace raycube::planner
