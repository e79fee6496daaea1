// Pulses of a survey fired for a trial of its sub-rays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "host/render/lidar_renderer.h"

namespace raycube::planner {

inline constexpr std::uint64_t kOtherPulses = 0x5bd1e995u;  ///< added to a seed, times 1, 2 ...: other draws
/// Of waveforms held while pulses are compared: 64 MB a side.
inline constexpr std::size_t kComparedFloats = std::size_t{1} << 24;

/// Receiver sampling: sub-rays start in the pixels and are the same in every pixel of every pulse.
inline bool receiver_sampling(const lidar::LidarPlan& plan) {
  return plan.lidar.transport.sampling == scene::LidarSampling::receiver;
}
/// Floats of a pulse's waveforms.
std::size_t floats_of_pulse(const lidar::LidarPlan& plan);

/// At most so many pulses of the survey by a hash of the seed, ascending: those among them that are fired (a
/// scanner that turns round fires in part of its pulses).
std::vector<std::uint64_t> hashed_pulses(const lidar::LidarPlan& plan, std::uint64_t most);

struct Firing {
  int subrays;
  std::uint64_t seed;
  bool moved;  ///< a receiver's samples move with the seed
};
struct Waveforms {
  std::vector<std::vector<float>> pulse;  ///< [pulse][pixel, line, bin]: surfaces, scattered once and more
};
/// Adds the rays traced to `rays`. Air and particles are left out: they are integrated along the beam, not by
/// sub-rays, and would only hide what surfaces do.
Waveforms fire_pulses(render::LidarRenderer& renderer, const lidar::LidarPlan& plan,
                      const std::vector<std::uint64_t>& pulses, const Firing& firing, std::uint64_t& rays);

}  // namespace raycube::planner
