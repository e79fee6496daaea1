// Whether the plan of an instrument carries thermal light. Beyond base::kHeatFrom_um it always does; below,
// where most scenes hold none that could be seen, it does where a material of the scene or the air of the
// table is warm enough.
#pragma once

#include <string>
#include <vector>

#include "host/plan/band_space.h"
#include "host/plan/sources.h"
#include "host/plan/spectral_plan.h"

namespace raycube::plan {

struct ThermalUse {
  bool on = false;
  /// What asks every used material for a temperature, as a message has it: thermal rows that reach 3 um, or
  /// vacuum beyond 4 um. Thermal light is then on whatever it makes. Empty: nothing does.
  std::string demanded_by;
  /// Largest radiance that one used material (not: their mean) or the table's air emits in a band, over the
  /// band's typical radiance without thermal light; 0 where nothing has a temperature, or where thermal light
  /// is demanded.
  double share = 0;
  std::size_t band = 0;  ///< of that share, from 0
  std::string from;      ///< who emits it: "material 'lava' at 1200 K" or "the air of the table"
  std::vector<std::string> notices;
  std::string without_paths;  ///< a notice more, where light does not go between surfaces; empty: none
};

/// `ThermalUse::demanded_by` of bands up to bands_to_um under a table with or without thermal rows that ends at
/// table_to_um.
std::string temperature_demand(bool vacuum, double bands_to_um, bool thermal_rows, double table_to_um);

/// limit: the share from which on thermal light is rendered. Radiance below 1e-12 W m-2 sr-1 um-1 is dark
/// whatever it is compared with: a pixel of 1e-10 m2 sr and 10 nm meets five photons of it in 1e6 s at 1 um.
ThermalUse thermal_use(const scene::Simulation& simulation, const scene::Instrument& instrument,
                       const atmos::RenderTable& table, const TableSpectra& air, const Domain& domain,
                       const BandSpace& bands, const SpectralPlan& spectral, double limit);

}  // namespace raycube::plan
