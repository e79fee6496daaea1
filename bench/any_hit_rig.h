// The kernels' single rays (kernels/geometry), launched on rays of one's choice: whether anything is hit, and what is
// hit first.
#pragma once

#include <memory>
#include <vector>

#include "bench/embree_baseline.h"

namespace raycube::bench {

class AnyHitRig {
 public:
  /// Rays with a direction each; hits: the triangles that they leave, on the side that they go to.
  AnyHitRig(const scene::CompiledScene& scene, const ShadowRays& rays, const std::vector<RayResult>& hits, int threads);
  ~AnyHitRig();
  AnyHitRig(const AnyHitRig&) = delete;
  AnyHitRig& operator=(const AnyHitRig&) = delete;

  /// Traces them all; seconds.
  double run();
  /// As EmbreeBaseline::shadow gives them.
  std::vector<RayResult> results() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The ray of paths from surface to surface.
class ClosestHitRig {
 public:
  ClosestHitRig(const scene::CompiledScene& scene, const ShadowRays& rays, int threads);
  ~ClosestHitRig();
  ClosestHitRig(const ClosestHitRig&) = delete;
  ClosestHitRig& operator=(const ClosestHitRig&) = delete;

  /// Traces them all; seconds.
  double run();
  /// As EmbreeBaseline::closest gives them, of the scene's numbers.
  std::vector<RayResult> results() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::bench
