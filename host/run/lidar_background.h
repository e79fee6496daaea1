// The light of sun and sky in a LIDAR's field of view.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "host/lidar/shot.h"
#include "host/render/types.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Whether light of the scene falls on the detector besides the pulses': asked for, and by day, or warm enough to shine
/// itself.
bool has_background(const scene::Simulation& simulation, const scene::Lidar& lidar);
/// The camera whose pixels see what the receiver does: a round field is a square of the same solid angle; 3 x 3
/// samples a pixel; bands ascend as the lines' wavelengths. A line for each shot; of an array the first shot's image.
scene::Instrument background_camera(const lidar::LidarPlan& plan, std::span<const lidar::Shot> shots);

/// Sun and sky reflected by the scene, seen by the receiver through each line's filter: the passive renderer's
/// background_camera.
class LidarBackground {
 public:
  LidarBackground(const scene::Simulation& simulation, const lidar::LidarPlan& plan,
                  const render::RenderOptions& options, Services& services);
  ~LidarBackground();

  /// Photons / s at the detector, [shot][pixel][line].
  std::vector<std::vector<double>> rates(const std::vector<lidar::Shot>& shots);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::run
