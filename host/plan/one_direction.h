// Imported tables of one line of sight: they say nothing of other directions and heights, though an axis of
// one node serves them all.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/plan/plan.h"

namespace raycube::plan {

/// Heights of what an instrument may see, m above scene z = 0.
struct HeightRange {
  double lo_m = 0, hi_m = 0;
};

/// Holds the paths of an instrument against the one that other codes computed, by the air on them: for
/// directions the secant, for heights an exponential of 8 km in parts of the whole column. Off by more than
/// 0.5 % (5.7 degrees from nadir, 40 m) is told, by more than 5 % (17.8 degrees, 400 m) an Error(input), both
/// with the angles or heights found. Off nadir, one azimuth for
/// all is told. Built tables and plain CSV, whose columns state that nothing varies, are left alone.
std::vector<std::string> one_direction_notices(const atmos::RenderTable& table, const std::string& instrument,
                                               const ViewBounds& view, const HeightRange& heights);

}  // namespace raycube::plan
