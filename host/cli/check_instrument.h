// Renders chosen pixels of one instrument on the device and holds them against the reference.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/reference/compare.h"
#include "host/render/picked_tiles.h"
#include "host/render/renderer.h"

namespace raycube::cli {

struct CheckOptions {
  std::uint64_t pixels = 500;          ///< at least so many, whole groups; all of the image when it has fewer
  std::size_t model_pixels = 64;       ///< of these, against the full tables
  int model_directions = 1024;
  int threads = 0;                     ///< of the reference; 0: all
};

using render::pick_tiles;
using render::pixels_of;

/// First hits of at least `rays` rays (of all when the image has fewer), device against Embree and double. Tiles of the image
/// picked as above; memory does not grow with `rays`. `progress`: called with the number of rays compared since the last call.
reference::HitReport check_hits(render::Renderer& renderer, const scene::CompiledScene& scene,
                                const scene::Instrument& instrument, std::uint64_t seed, std::uint64_t rays, int threads,
                                const std::function<void(std::uint64_t)>& progress = {});

/// `progress`: called with the number of pixels compared since the last call.
reference::Report check_instrument(render::Renderer& renderer, const scene::Simulation& simulation,
                                   const scene::Instrument& instrument, const plan::Plan& plan,
                                   const atmos::RenderTable& table, const CheckOptions& options,
                                   const std::function<void(std::uint64_t)>& progress = {});

}  // namespace raycube::cli
