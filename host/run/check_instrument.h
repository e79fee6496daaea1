// Renders chosen pixels of one instrument on the device and holds them against the reference.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/reference/compare.h"
#include "host/render/picked_tiles.h"
#include "host/render/renderer.h"
#include "host/run/camera_job.h"
#include "host/run/services.h"
#include "host/sensors/small_objects.h"

namespace raycube::run {

struct CheckOptions {
  std::uint64_t pixels = 500;     ///< at least so many, whole groups; all of the image when it has fewer
  std::size_t model_pixels = 64;  ///< of these, against the full tables
  int model_directions = 1024;
  int threads = 0;  ///< of the reference; 0: all
};

/// Where pixel p of a tile lies, and its group among the tile's; width: pixels of a group.
reference::PixelAddress address_of(const render::HitProbe& probe, std::size_t p, int width);

/// The instrument with the samples of every pixel traced once and kept: adaptive pixels and means of replicates keep
/// none to compare.
scene::Instrument compared_in_full(const scene::Instrument& instrument);

/// First hits of at least `rays` rays (of all when the image has fewer), device against Embree and double. Tiles of the
/// image picked as above; memory does not grow with `rays`. `progress`: called with the number of rays compared since
/// the last call.
reference::HitReport check_hits(render::Renderer& renderer, const scene::CompiledScene& scene,
                                const scene::Instrument& instrument, std::uint64_t seed, std::uint64_t rays,
                                int threads, const std::function<void(std::uint64_t)>& progress = {});

/// The pixels that small objects have rendered with more samples: a report for each number of samples, of
/// groups picked by hash, with at most kSmallObjectRays rays each (one group at least). Empty where there are
/// none.
struct SmallObjectReport {
  int samples = 0;           ///< of a pixel
  std::uint64_t pixels = 0;  ///< of the image that have so many
  reference::Report report;
};
inline constexpr std::uint64_t kSmallObjectRays = 1u << 17;
std::vector<SmallObjectReport> check_small_objects(render::Renderer& renderer, const scene::Simulation& simulation,
                                                   const scene::Instrument& instrument, const plan::Plan& plan,
                                                   const atmos::RenderTable& table,
                                                   const sensors::SmallObjectSurvey& survey,
                                                   const CheckOptions& options);

/// Pixels of pick_tiles with the ordinary samples. `progress`: called with the number of pixels compared
/// since the last call.
reference::Report check_instrument(render::Renderer& renderer, const scene::Simulation& simulation,
                                   const scene::Instrument& instrument, const plan::Plan& plan,
                                   const atmos::RenderTable& table, const CheckOptions& options,
                                   const std::function<void(std::uint64_t)>& progress = {});

/// All that `check` compares of a camera. Without rays the report holds no first hits of its own.
struct CameraCheck {
  reference::Report report;
  std::vector<SmallObjectReport> small;
};
CameraCheck check_camera(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job,
                         const CheckOptions& options, std::uint64_t rays, const Services& services);

}  // namespace raycube::run
