// A camera's run: rendered, written and told.
#pragma once

#include <string>

#include "host/render/types.h"
#include "host/run/camera_job.h"
#include "host/run/destination.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// What is told of a cube that is whole.
struct CameraRun {
  std::string name, folder;
  std::string digest;  ///< of the products
  std::string cube;    ///< path of radiance.img
  double seconds = 0, rays_per_s = 0, band_samples_per_s = 0;
};

/// Renders on the renderer's device, within the options' memory, and publishes every file in the destination.
CameraRun render_camera(const scene::Simulation& simulation, const CameraJob& job, render::Renderer& renderer,
                        const render::RenderOptions& options, const Destination& destination, Services& services);

}  // namespace raycube::run
