#include "host/planner/lidar_fire.h"

#include <algorithm>
#include <set>
#include <utility>

#include "host/lidar/footprint.h"
#include "kernels/sampling/sampler.h"

namespace raycube::planner {

namespace {

constexpr rc_u32 kPulseDimension = 45, kShiftDimension = 48;

}  // namespace

std::size_t floats_of_pulse(const lidar::LidarPlan& plan) {
  return static_cast<std::size_t>(plan.pixels()) * static_cast<std::size_t>(plan.lines()) *
         static_cast<std::size_t>(plan.lidar.gate.bins);
}

std::vector<std::uint64_t> hashed_pulses(const lidar::LidarPlan& plan, std::uint64_t most) {
  const auto all = static_cast<std::uint64_t>(std::max<std::int64_t>(plan.lidar.pulses, 0));
  const auto low = static_cast<rc_u32>(plan.seed), high = static_cast<rc_u32>(plan.seed >> 32);
  std::set<std::uint64_t> picked;
  for (rc_u32 i = 0; picked.size() < std::min(most, all); ++i)
    picked.insert(all <= most ? i : rc_hash(low, i, high, kPulseDimension) % all);
  std::vector<std::uint64_t> fired;
  for (const std::uint64_t pulse : picked)
    if (!lidar::make_shots(plan.lidar, static_cast<std::int64_t>(pulse), 1, plan.seed).empty()) fired.push_back(pulse);
  return fired;
}

Waveforms fire_pulses(render::LidarRenderer& renderer, const lidar::LidarPlan& given,
                      const std::vector<std::uint64_t>& pulses, const Firing& firing, std::uint64_t& rays) {
  lidar::LidarPlan plan = given;
  plan.lidar.transport.subrays = firing.subrays;
  plan.seed = firing.seed;
  const bool exits = lidar::exit_matters(plan.lidar);
  if (firing.moved) {
    const auto low = static_cast<rc_u32>(firing.seed), high = static_cast<rc_u32>(firing.seed >> 32);
    plan.footprint = lidar::make_footprint(
        plan.lidar, exits,
        {rc_hash(low, high, 0u, kShiftDimension) * 0x1p-32, rc_hash(low, high, 1u, kShiftDimension) * 0x1p-32});
  } else {
    plan.footprint = lidar::make_footprint(plan.lidar, exits);
  }
  plan.lidar.transport.air_return = false;
  std::vector<lidar::Shot> shots;
  for (const std::uint64_t pulse : pulses) {
    const auto made = lidar::make_shots(plan.lidar, static_cast<std::int64_t>(pulse), 1, firing.seed);
    shots.insert(shots.end(), made.begin(), made.end());
  }
  Waveforms out;
  renderer.render(plan, shots, [&](lidar::ShotResult&& shot) {
    std::vector<float> row = std::move(shot.first);
    for (std::size_t i = 0; i < shot.multiple.size(); ++i) row[i] += shot.multiple[i];
    rays += static_cast<std::uint64_t>(std::max<std::int64_t>(0, shot.rays));
    out.pulse.push_back(std::move(row));
  });
  return out;
}

}  // namespace raycube::planner
