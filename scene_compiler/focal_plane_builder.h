// [[instrument.focal_plane]]: point spreads, offsets and distortions.
#pragma once

#include "scene_compiler/document.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// The focal planes of an instrument whose other keys have been read, checked; each band is seen by one.
void read_focal_planes(const Record& instrument, Instrument& out, base::Problems& problems);

}  // namespace raycube::scene
