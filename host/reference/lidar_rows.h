// Waveforms of one shot in double, and the ledger of what fell outside the gate.
#pragma once

#include <vector>

#include "host/lidar/lidar_plan.h"
#include "host/reference/lidar_pulse.h"

namespace raycube::reference {

/// Rows [pixel][line][bin], photons at the detector; empty where nothing of the kind can come.
struct LidarRows {
  std::vector<double> first, multiple, air;  ///< as in lidar::ShotResult, but `first` is of surfaces alone
  std::vector<double> particles;             ///< once scattered by volumes
};

class LidarGate {
 public:
  /// slope_s > 0: rows get how much each echo's share of a bin changes, without sign, when it comes so much later.
  explicit LidarGate(const lidar::LidarPlan& plan, double slope_s = 0);

  double bin_s() const { return bin_s_; }
  /// Times at which an echo's middle may still leave something in the gate.
  double earliest_s() const { return start_s_ - shape_.last_s(); }
  double latest_s() const { return end_s_ - shape_.first_s(); }
  double start_s() const { return start_s_; }

  /// Adds an echo whose middle arrives at `time_s`; its parts before and after the gate go to the ledger with all of
  /// it.
  void deposit(std::vector<double>& rows, int pixel, int line, double time_s, double photons,
               lidar::Ledger& ledger) const;

 private:
  LidarPulseShape shape_;
  double start_s_, bin_s_, end_s_, slope_s_;
  int bins_;
  std::vector<double> emitted_;  ///< [line], photons
};

}  // namespace raycube::reference
