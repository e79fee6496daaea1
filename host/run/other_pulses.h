// Range ambiguity: light of other pulses that arrives while a pulse's gate is open.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "host/render/lidar_renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Pulses fired k periods earlier (and, with several in the air at once, later ones too) return into the gate with
/// their own time: they are rendered again with the gate moved by whole periods. As far back as light from the scene's
/// farthest corner, volumes included, takes.
class OtherPulses {
 public:
  /// Nothing to do unless fold_ambiguous.
  OtherPulses(const scene::Simulation& simulation, const lidar::LidarPlan& plan);

  /// Adds their rows, and to `collected` of each line what they bring into the gate. `ready` makes a survey's shot as
  /// it is fired, turbulence included. hits: with first hits of the others, for truth.
  void add_to(std::vector<lidar::ShotResult>& results, render::LidarRenderer& renderer,
              const std::function<void(lidar::Shot&)>& ready, bool hits) const;

  /// The plan whose gate, its own or moved by whole periods, sees most light of surfaces in a few pulses: where
  /// sub-rays and their error are tried. The one given where no other sees more.
  lidar::LidarPlan brightest(const lidar::LidarPlan& plan, render::LidarRenderer& renderer) const;

 private:
  struct Other {
    std::int64_t back = 0;  ///< periods; below 0: a later pulse
    lidar::LidarPlan plan;
  };

  std::uint64_t seed_;
  std::int64_t pulses_;
  std::vector<Other> others_;
};

}  // namespace raycube::run
