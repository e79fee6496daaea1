// The two-way factor where it says something, for reports.
#pragma once

#include <vector>

#include "atmos_tables/render_table.h"

namespace raycube::atmos::detail {

/// R2, and NaN where T_sun T_view is not above 0.001: the ratio of two vanishing numbers says nothing.
std::vector<double> lit_two_way_factor(const RenderTable& table, double height_m, double zenith_deg);

}  // namespace raycube::atmos::detail
