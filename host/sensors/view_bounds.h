// What a plan must cover of an instrument's view.
#pragma once

#include "host/plan/plan.h"

namespace raycube::sensors {

/// Extremes over the centres and corners of all pixels; the corners are those of the sampled square when a
/// point spread reaches past the pixel. sensor_height_m is the mean height of the poses. Throws Error(input)
/// on a ray that does not look down (d.z >= 0): the tables have no such view yet. Only pixels that can be
/// extreme are looked at: near the ends of lines, and where a component of the direction turns; the values
/// are those of a walk over all pixels.
plan::ViewBounds view_bounds(const scene::Instrument& instrument);

}  // namespace raycube::sensors
