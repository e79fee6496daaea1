// The verb `raycube atmos lidar`: profiles of extinction and backscatter at laser wavelengths.
#pragma once

#include <string>

#include "atmos_tables/render_table.h"
#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_atmos_lidar();

/// Figures of a table of LIDAR profiles for host/plots/lidar_plot.py: wavelengths, heights, extinction and backscatter,
/// m-1 (sr-1).
std::string lidar_figures_json(const atmos::RenderTable& table, const std::string& title);

}  // namespace raycube::cli
