// From a simulation's LIDAR to the plan that device and reference share.
#pragma once

#include "atmos_tables/render_table.h"
#include "host/lidar/lidar_plan.h"
#include "scene_compiler/simulation.h"

namespace raycube::lidar {

/// Nodes of all lines: one for a monochromatic line, else Gauss-Hermite nodes of the Gaussian line (LIDAR
/// specification, 2.3).
std::vector<SpectralNode> make_nodes(const scene::Lidar& lidar);

/// `table`: LIDAR profiles at table_wavelengths(make_nodes(lidar)); null: no air. Throws Error(input) for materials in
/// use that have no reflectance at a line, for a reflectance plus transmittance above 1, and for gases without cross
/// sections there.
LidarPlan make_lidar_plan(const scene::Simulation& simulation, const scene::Lidar& lidar,
                          const atmos::RenderTable* table);

}  // namespace raycube::lidar
