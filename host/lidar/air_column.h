// The air's extinction and backscatter along height, for the nodes of a LIDAR's lines.
#pragma once

#include "atmos_tables/render_table.h"
#include "host/lidar/lidar_plan.h"

namespace raycube::lidar {

/// Wavelengths a table of LIDAR profiles needs for these nodes: ascending, each once, um.
std::vector<double> table_wavelengths(const std::vector<SpectralNode>& nodes);

/// Posts at most 20 m apart (25 m at 100 km) from low_m to high_m; depth between posts is off by at most dz^2/8 of the
/// extinction's slope: 0.6 % of one post's depth where it falls by e in 1 km, 1e-5 of a path of 1 km. Backscatter of a
/// line is its nodes' mean. Below the table's lowest height the air of that height goes on. Throws Error(input) when
/// high_m is above the table and below 100 km.
AirColumn make_air(const atmos::RenderTable& table, const std::vector<SpectralNode>& nodes, int lines, double low_m,
                   double high_m);

}  // namespace raycube::lidar
