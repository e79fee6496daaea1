// A LIDAR run's files as differential absorption needs them.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "host/lidar/dial.h"

namespace raycube::run {

/// What waveforms.img and pulses.csv of a run's folder say, record by record.
class DialRun {
 public:
  /// Finds the bands of every line of the plan. Error(input): files missing, no recorded waveforms, a gate or lines
  /// unlike the plan's.
  DialRun(const std::string& folder, const lidar::LidarPlan& plan);
  ~DialRun();

  std::int64_t records() const;  ///< pulses times pixels

  struct Line {
    std::vector<float> recorded;   ///< photo-electrons a bin
    std::vector<double> expected;  ///< photo-electrons a bin, noiseless, without background
    double background_pe = 0, speckle_modes = 0;
  };
  struct Record {
    std::int64_t pulse = 0;
    int pixel = 0;
    std::array<double, 3> exit_m{}, axis{};
    std::vector<Line> lines;
  };
  Record read(std::int64_t number) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::run
