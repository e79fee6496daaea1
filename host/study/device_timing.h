// One setting tried on the device: its radiances at the picked pixels, its counts, and its times.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/render/picked_tiles.h"
#include "host/render/renderer.h"

namespace raycube::study {

/// [pixel][band] of the tiles' pixels in their order.
std::vector<float> device_radiance(render::Renderer& renderer, const scene::Instrument& instrument,
                                   const plan::Plan& plan, const scene::Sun& sun, std::uint64_t seed,
                                   const std::vector<render::Tile>& tiles);

struct Timing {
  double median_s = 0, low_s = 0, high_s = 0;  ///< of a whole image: fixed part + its pixels; least and largest repeat
  std::map<std::string, double> stage_s;       ///< of the median repeat, of the timed pixels
  std::uint64_t pixels = 0;                    ///< timed
  double rays_per_pixel = 0;                   ///< primary, sun and sky
  double terms_per_pixel = 0;                  ///< median
};

/// Renders the tiles once to warm up and then `repeats` times. Baking counts once per image, every other stage by the
/// pixel; writing is not timed.
Timing time_image(render::Renderer& renderer, const scene::Instrument& instrument, const plan::Plan& plan,
                  const scene::Sun& sun, std::uint64_t seed, const std::vector<render::Tile>& tiles, int repeats);

}  // namespace raycube::study
