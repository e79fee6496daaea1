// A few pixels that stand for an image: picked by hash for accuracy, whole strips for time.
#pragma once

#include <cstdint>
#include <vector>

#include "host/render/tile_shape.h"

namespace raycube::render {

/// Tiles that hold the pixels to check: groups picked by a hash of the seed and a counter, or every line of the image.
std::vector<Tile> pick_tiles(const scene::Instrument& instrument, std::uint64_t seed, std::uint64_t pixels);

/// Pixels that tiles hold.
std::uint64_t pixels_of(const std::vector<Tile>& tiles);

/// Up to four strips, evenly over the image, of about so many pixels together: enough work-items at once to time what a
/// render does.
std::vector<Tile> timing_tiles(const scene::Instrument& instrument, std::uint64_t pixels);

}  // namespace raycube::render
