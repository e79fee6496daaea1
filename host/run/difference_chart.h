// The difference picture of `check` as a chart that explains itself.
#pragma once

#include <string>

#include "host/products/raster.h"
#include "host/reference/compare.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Columns bands, rows compared pixels in image order (the worst of each bunch when there are many), colours of
/// reference::difference_colour with their scale, band centres in nm below, image lines at the left.
products::Raster difference_chart(const reference::Report& report, const scene::Instrument& instrument);

}  // namespace raycube::run
