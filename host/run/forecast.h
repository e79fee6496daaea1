// What a camera's run would take, without running it: its image's tiles, memory, bytes and time.
#pragma once

#include <cstdint>

#include "host/render/renderer.h"
#include "host/run/camera_job.h"

namespace raycube::run {

/// Bytes are estimates of what raycube itself holds; the OpenCL driver and its compiler come on top (PoCL: about
/// 200 MiB).
struct CameraForecast {
  int samples = 0;  ///< of a pixel
  int tile_lines = 0, tile_columns = 0;
  std::uint64_t budget_bytes = 0, scene_bytes = 0, tile_bytes = 0, strip_bytes = 0;
  std::uint64_t baked_rows_bytes = 0;  ///< at most, on top of the total
  std::uint64_t cube_bytes = 0, truth_bytes = 0;

  std::uint64_t total_bytes() const { return scene_bytes + tile_bytes + strip_bytes; }
};

/// tile_samples: of the device (render::DeviceTuning).
CameraForecast forecast_camera(const scene::CompiledScene& scene, const CameraJob& job,
                               const render::RenderOptions& options, std::size_t tile_samples);

/// Seconds a render will take on the nominal machine (planner::CostModel): its samples, and those that small objects'
/// pixels get besides.
double nominal_render_s(const CameraJob& job);

/// Seconds a render will take on the renderer's device without reading, planning and building programs: the time of
/// short stretches of four lines spread over the image, times the pixels. Good to about a factor of two: small tiles
/// meet neither the writing nor memory that is touched for the first time.
double estimate_render_s(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job);

}  // namespace raycube::run
