// Where a LIDAR run's light went, to say why its records are empty.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/lidar/detection.h"
#include "host/lidar/lidar_plan.h"

namespace raycube::run {

/// Sums over the pulses of a run.
class LidarRunLight {
 public:
  explicit LidarRunLight(const lidar::LidarPlan& plan) : plan_(plan) {}

  void add(const lidar::ShotResult& result, const std::vector<lidar::Detection>& records);

  /// One sentence where no return was found, or none can be of a surface or volume; with the reason by the
  /// energy ledger. Empty: all is well.
  std::string warning() const;

  /// Returns that surfaces and volumes are expected to have made, of all found: each counts by their share of
  /// what an echo's width of the record holds.
  double returns_of_matter() const { return returns_of_matter_; }

 private:
  void add_returns(const lidar::ShotResult& result, const lidar::Detection& record);
  std::string where_it_went() const;

  const lidar::LidarPlan& plan_;
  double half_bins_ = 0;  ///< of an echo, to either side; known from the first shot on
  std::uint64_t shots_ = 0, echoes_ = 0;
  double returns_of_matter_ = 0;
  double records_ = 0;                                 ///< pixels and lines of all shots
  double matter_photons_ = 0, air_photons_ = 0;        ///< in the gates, of surfaces and volumes, of the air
  double strongest_pe_ = 0, lowest_threshold_pe_ = 0;  ///< expected in a bin; of any record
  lidar::Ledger mean_;                                 ///< sums until divided by ledgers_
  double ledgers_ = 0;
};

}  // namespace raycube::run
