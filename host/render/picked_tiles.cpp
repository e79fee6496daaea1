#include "host/render/picked_tiles.h"

#include <algorithm>
#include <set>

#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::render {

namespace {

constexpr rc_u32 kPickDimension = 41;  ///< of the hash: no sampler uses it
/// Pixels of a whole line that are traced at once; a multiple of 4.
constexpr int kMostColumns = 256;

}  // namespace

std::vector<Tile> pick_tiles(const scene::Instrument& instrument, std::uint64_t seed, std::uint64_t pixels) {
  const int width = sensors::pixels_per_group(instrument), per_line = sensors::groups_per_line(instrument);
  const std::uint64_t groups = static_cast<std::uint64_t>(per_line) * static_cast<std::uint64_t>(instrument.lines);
  const std::uint64_t wanted = (pixels + static_cast<std::uint64_t>(width) - 1) / static_cast<std::uint64_t>(width);
  std::vector<Tile> tiles;
  if (2 * wanted >= groups) {
    for (int line = 0; line < instrument.lines; ++line)
      for (int column = 0; column < instrument.pixels; column += kMostColumns)
        tiles.push_back({line, 1, column, std::min(kMostColumns, instrument.pixels - column)});
    return tiles;
  }
  // A tile starts at a multiple of 4 pixels, whatever the groups.
  const int tile_width = std::max(width, RC_GROUP_WIDTH);
  const int tiles_per_line = (instrument.pixels + tile_width - 1) / tile_width;
  const auto all = static_cast<rc_u32>(tiles_per_line * instrument.lines);
  const std::uint64_t count =
      (pixels + static_cast<std::uint64_t>(tile_width) - 1) / static_cast<std::uint64_t>(tile_width);
  std::set<rc_u32> taken;
  for (rc_u32 i = 0; tiles.size() < std::min<std::uint64_t>(count, all); ++i) {
    const rc_u32 place = rc_hash(static_cast<rc_u32>(seed), i, static_cast<rc_u32>(seed >> 32), kPickDimension) % all;
    if (!taken.insert(place).second) continue;
    const int line = static_cast<int>(place) / tiles_per_line,
              column = static_cast<int>(place) % tiles_per_line * tile_width;
    tiles.push_back({line, 1, column, std::min(tile_width, instrument.pixels - column)});
  }
  return tiles;
}

std::uint64_t pixels_of(const std::vector<Tile>& tiles) {
  std::uint64_t pixels = 0;
  for (const Tile& tile : tiles) pixels += tile.pixels();
  return pixels;
}

std::vector<Tile> timing_tiles(const scene::Instrument& instrument, std::uint64_t pixels) {
  constexpr int strips = 4, widest = 1024;
  const std::uint64_t of_strip = (pixels + strips - 1) / strips,
                      whole_groups = (of_strip + RC_GROUP_WIDTH - 1) / RC_GROUP_WIDTH * RC_GROUP_WIDTH;
  const int columns =
      static_cast<int>(std::min<std::uint64_t>({static_cast<std::uint64_t>(instrument.pixels), widest, whole_groups}));
  const std::uint64_t wanted = std::max<std::uint64_t>(1, of_strip / static_cast<std::uint64_t>(columns));
  // Only a tile of full width may have several lines.
  const int lines =
      columns < instrument.pixels
          ? 1
          : static_cast<int>(std::min<std::uint64_t>(wanted, static_cast<std::uint64_t>(instrument.lines)));
  std::vector<Tile> tiles;
  const int count = std::clamp(instrument.lines / lines, 1, strips);
  for (int strip = 0; strip < count; ++strip) {
    const int room = instrument.lines / count, first = strip * room + (room - lines) / 2;
    const int column = (instrument.pixels - columns) / 2 / RC_GROUP_WIDTH * RC_GROUP_WIDTH;
    tiles.push_back({first, lines, column, columns});
  }
  return tiles;
}

}  // namespace raycube::render
