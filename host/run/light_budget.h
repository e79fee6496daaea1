// Where the light goes that falls onto a level area, as `raycube measure` finds it: by photons from their source on.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/render/types.h"
#include "host/run/facet_light.h"
#include "host/run/measure.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Surfaces that a photon meets at most; what it still carries then is told.
inline constexpr int kMostMet = 1000;

/// Shares of the light that falls onto the area, one for each of its bands.
struct LightShare {
  std::string quantity;
  std::string of;  ///< a material, or a level's height; else empty
  std::vector<Measured> band;
};

struct BudgetResult {
  std::vector<std::string> band;               ///< as files name it: 650nm, and par
  std::vector<double> wavelength_um;           ///< [band], centres
  std::vector<std::optional<double>> light_w;  ///< [band]: on the level area, W m-2 um-1; none: no such number
  std::vector<LightShare> share;

  /// Precondition: it is among them.
  const LightShare& of(const std::string& quantity, const std::string& name = "") const;
};

/// Bands that a budget is of: its instrument's, and where it asks for it that of photosynthesis, named "par".
std::vector<scene::Band> budget_bands(const scene::Simulation& simulation, const scene::LightBudget& budget);

/// Throws Error(input): a sun that is down, bands where surfaces shine by themselves, an empty scene.
void check_budget(const scene::Simulation& simulation, const scene::LightBudget& budget);

/// The air is left out of the simulation. facet_files: for the meshes of budget.facets, in their order. Shares are
/// means over 16 batches of photons with draws of their own, their standard errors from the batches. A photon is
/// followed surface by surface (render::PhotonTracer), 1000 of them at most; what it carries is what a material's
/// curves leave of it, at every wavelength of the plan's grid, and a band's share is the mean over the band weighed
/// by response and sunlight. Of what is met 1 - R - T is absorbed; where a surface does not reflect by Lambert's
/// law, or is glossy, 1 less what goes in the direction that was drawn. Through a plate light goes straight on. In a
/// scene that repeats photons that leave the cell come in at its other side, at each surface that they meet.
/// Quantities: reflected (the albedo: directional-hemispherical under the sun, bihemispherical under isotropic light),
/// absorbed and arrived of each material, canopy (absorbed by all but the ground), transmitted and
/// transmitted_uncollided (light that falls onto the ground; that met nothing before), down and up of each level, lost
/// (past the scene's edge) and unfinished. reflected, all absorbed, lost and unfinished sum to 1 in the mean.
BudgetResult light_budget(const render::RenderOptions& options, scene::Simulation& simulation,
                          const scene::LightBudget& budget, const std::vector<base::OutputFile*>& facet_files,
                          Services& services);

/// A table: rows quantity by quantity, band by band.
void write_budget(const scene::LightBudget& budget, const BudgetResult& result, base::OutputFile& file);
nlohmann::ordered_json budget_json(const scene::LightBudget& budget, const BudgetResult& result);

}  // namespace raycube::run
