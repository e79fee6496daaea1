// The ways in which exit and pupil of shots lie to one another: tables of a beam's overlap with the field are made once
// for each.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "kernels/shared/structs.h"

namespace raycube::render {

/// Number of a geometry among those met so far, and a record of each (kernels/lidar/layout.h) in a frame of its own:
/// exit at 0, beam along z. It depends on the geometry alone, rounded to 1 um and 1 nrad, never on the shots that came
/// before. The footprint's turn is left out.
class LidarBeams {
 public:
  LidarBeams(const lidar::LidarPlan& plan) : plan_(plan) {}
  std::uint32_t number(const lidar::Shot& shot, int pixel);
  void clear();
  const std::vector<shared::rc_float4>& records() const { return records_; }
  std::size_t size() const { return numbers_.size(); }

 private:
  const lidar::LidarPlan& plan_;
  std::map<std::array<std::int64_t, 9>, std::uint32_t> numbers_;
  std::vector<shared::rc_float4> records_;
};

}  // namespace raycube::render
