// Boxes of what a scene places, and whether single precision resolves it there.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene_compiler/scene_builder.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// World box, m; lo > hi: nothing in it.
struct PlacedBox {
  std::array<float, 3> lo, hi;
  double own_spacing_m = 0;  ///< of coordinates in its file, where that is far from their origin, as placed
  double size_m = 0;         ///< its longest extent before the corners were rounded to single precision
  bool empty() const { return !(lo[0] <= hi[0]); }
};

/// Of every placed mesh, in the order of parts.placed: its mesh's box, turned with it, so not smaller than it
/// is.
std::vector<PlacedBox> placed_boxes(const SceneParts& parts);
/// Around all of them.
PlacedBox box_around(const std::vector<PlacedBox>& boxes);

/// Coordinates are single precision in the scene's frame: their spacing is 2^-23 of the power of two below, 1
/// m at 1e7 m. Objects (of terrains: cells) of which that is more than a tenth are an error, more than a
/// thousandth a notice: shadows lose up to 7 times the spacing (a box of 2 m under a sun at 45 degrees, whose
/// dark place is 8 m2: 7.8 at 1e5 m, 7.5 at 3e5 m, 6.3 at 1e6 m, 3.2 at 1e7 m).
void check_resolution(const SceneParts& parts, const std::vector<PlacedBox>& boxes, const std::string& file,
                      std::vector<std::string>& notices, base::Problems& problems);

/// Numbers of the objects whose box lies below the highest terrain at its four corners and its middle, where all of
/// these are on one: nothing above sees them. Told once: how many, and the first.
std::vector<std::uint32_t> find_buried(const SceneParts& parts, const std::vector<PlacedBox>& boxes,
                                       const std::string& file, std::vector<std::string>& notices);

/// Cameras, LIDARs and lamps that stand below the highest terrain at their place, each told once with the first place.
void tell_of_buried(const SceneParts& parts, const Simulation& simulation, std::vector<std::string>& notices);

}  // namespace raycube::scene
