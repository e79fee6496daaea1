// [[instrument]] entries: scale, poses, bands, sampling.
#pragma once

#include <string>
#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/scene_builder.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Every instrument, checked; heights above ground come from the terrains of `parts` (0 off them).
std::vector<Instrument> read_instruments(const Record& root, const SceneParts& parts, std::vector<std::string>& notices,
                                         base::Problems& problems);

/// Poses of a straight flight at constant height along heading_deg, the middle of the image at `middle`.
/// Pushbroom: one per line, line_spacing_m apart, line 0 flown first. Whiskbroom: one per pixel; within a
/// line the platform moves on, one line spacing per line, evenly over the samples.
std::vector<Pose> straight_flight(InstrumentKind kind, int lines, int pixels, const Pose& middle,
                                  double line_spacing_m);

/// One pose per pixel from one per line, linear in time (angles the short way), extrapolated over the outer
/// half lines. A single line is held.
std::vector<Pose> poses_per_pixel(const std::vector<Pose>& per_line, int pixels);

}  // namespace raycube::scene
