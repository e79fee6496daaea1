// The tracing stages of render, launched on rays of one's choice: the same class, source and options, so the same
// programs.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "bench/embree_baseline.h"
#include "scene_compiler/simulation.h"

namespace raycube::bench {

class TraceRig {
 public:
  /// `sun`: unit vector towards it. Up to `max_groups` groups a run; the instrument gives samples and sampler.
  TraceRig(const scene::CompiledScene& scene, const scene::Instrument& instrument, std::size_t max_groups,
           const std::array<float, 3>& sun, int threads);
  ~TraceRig();
  TraceRig(const TraceRig&) = delete;
  TraceRig& operator=(const TraceRig&) = delete;

  /// Rays of the next runs.
  void set_groups(const std::vector<shared::RayGroup>& groups);

  struct Times {
    double primary_s = 0, sun_s = 0;
  };
  /// Primary rays, surface points, sun. `first_line` keys the random samplers: another line, other samples.
  Times run(std::uint32_t first_line = 0);

  /// As EmbreeBaseline::primary and ::shadow would give them, [pixel * samples + sample].
  std::vector<RayResult> hits() const;
  std::vector<RayResult> sun() const;
  /// The rays the sun stage traced: NaN where the ray missed or the surface faces away.
  ShadowRays shadow_rays() const;
  /// From the same points, one ray each in a direction of its own, its density cosine / pi about the surface's normal;
  /// NaN where the primary ray missed.
  ShadowRays sky_rays() const;

  /// SHA-256 of source and options of the programs of first rays and of sun rays, and of how samples lie.
  std::string program_hash() const;
  std::string device_name() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::bench
