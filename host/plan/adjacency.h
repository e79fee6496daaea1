// Light between ground and air (S4.9) in the plan: whether there is any, the map of the ground around every place, its
// spectra.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/plan/band_space.h"
#include "host/plan/plan.h"
#include "host/plan/sources.h"

namespace raycube::plan {

/// What of [atmosphere] adjacency this table and air allow. Error(input) when the file asks for what the table lacks.
scene::Adjacency choose_adjacency(const scene::Simulation& simulation, const atmos::RenderTable& table);
/// The same of a table that has the rows of light between ground and air, or has not, before it is there.
scene::Adjacency choose_adjacency(const scene::Simulation& simulation, bool table_has_coupling);

/// Makes plan.environment and returns the scene's mean reflectance on the covered wavelengths, the first of which is
/// number `first` of the table's. Error(input) where mean and spherical albedo let light grow without end. On as many
/// threads (0: all), the same on any number.
Spectrum plan_environment(Plan& plan, const scene::Simulation& simulation, const atmos::RenderTable& table,
                          const Domain& domain, bool local, const std::vector<double>& covered_um, std::size_t first,
                          int threads);

/// Fills plan.environment_spectrum at the plan's nodes of height and view, and the map's curves on the plan's grid.
void add_environment_spectra(Plan& plan, const scene::Simulation& simulation, const TableSpectra& air,
                             const BandSpace& bands, const std::vector<double>& covered_um,
                             const std::vector<double>& grid_um);

/// Materials of the scene's mean ground and their area shares, for the plan's report.
std::vector<std::pair<std::string, double>> mean_ground(const EnvironmentMap& map, const scene::CompiledScene& scene);

}  // namespace raycube::plan
