// The converged double-precision solution of a few pixels: Embree, full tables, many samples, sky directions spread
// over them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/plan/plan.h"
#include "host/render/picked_tiles.h"
#include "host/study/error_figures.h"

namespace raycube::study {

/// Two halves of `grid` x `grid` samples each, one at random in every cell (no plan's grid or lattice), each looking
/// into `per_sample` of `directions` sky directions.
struct ConvergedSettings {
  int grid = 31;
  int directions = 1024, per_sample = 8;
  int levels = 0, paths = 2048;  ///< of light between surfaces: surfaces after the first, paths of each half
  int threads = 0;               ///< 0: all
};

/// Pixels of the tiles in their order. `plan` lends its spectral grid, bands, the heights and the extent of the ground
/// around; its nodes and its sky's components for light between surfaces alone. `progress`: called with the pixels done
/// since the last call. Throws Error(interrupted).
Converged converge(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan,
                   const atmos::RenderTable& table, const std::vector<render::Tile>& tiles,
                   const ConvergedSettings& settings, const std::function<void(std::uint64_t)>& progress = {});

}  // namespace raycube::study
