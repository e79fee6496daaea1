// The table [instrument.detector] of a simulation file.
#pragma once

#include "scene_compiler/detector_spec.h"
#include "scene_compiler/document.h"

namespace raycube::scene {

/// Of an instrument's table; reports what does not go together.
DetectorSpec read_detector(const Record& detector, base::Problems& problems);

}  // namespace raycube::scene
