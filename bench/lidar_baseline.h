// Embree's side of the LIDAR figures: the same sub-rays in coherent packets of 16, the same returns into the same bins.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/embree_baseline.h"
#include "host/lidar/lidar_plan.h"

namespace raycube::bench {

/// Shots as fp32 rays and what turns a hit into a return; Lambert, monostatic, one line, full overlap, no air.
struct LidarWork {
  std::vector<shared::RayGroup> groups;  ///< one a shot: origin, axis, u and v times the tangent of the divergence
  std::vector<float> a, b;               ///< sub-rays, shared by all shots
  std::vector<float> start_m;            ///< one way distance at which each shot's gate begins
  float bins_per_m = 0;                  ///< of one way distance
  int bins = 0;
  float weight = 0;                                 ///< photons times aperture over pi, of one sub-ray
  const std::vector<float>* reflectance = nullptr;  ///< of each surface
  const lidar::PulseTaps* taps = nullptr;
};

class LidarBaseline {
 public:
  LidarBaseline(const EmbreeBaseline& embree, const scene::CompiledScene& scene);
  /// Rows have padding in front and behind, so that pulses that hang over the gate's ends need no branch.
  static std::size_t row_pad(const LidarWork& work);
  static std::size_t row_floats(const LidarWork& work);
  /// The first place from `at` on that begins a cache line.
  static float* on_line(float* at);
  /// rows[shot * row_floats + row_pad + bin], on a cache line, cleared first. Traced and binned in one pass over the
  /// shots; pulses without corners, of up to 64 taps.
  void run(const LidarWork& work, int threads, float* rows) const;

 private:
  template <int Vectors>
  void run_of(const LidarWork& work, int threads, float* rows) const;
  const EmbreeBaseline& embree_;
  const scene::CompiledScene& scene_;
  std::vector<std::vector<std::uint32_t>> surface_;  ///< [tree][Embree's primitive]
};

}  // namespace raycube::bench
