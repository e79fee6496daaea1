// The spectral half of a plan: which curves count, whether every band can be served, the grid and the bands' weights.
#pragma once

#include <map>
#include <string>

#include "host/base/error.h"
#include "host/plan/plan.h"

namespace raycube::plan {

struct SpectralPlan {
  std::vector<double> wavelength_um;
  std::vector<BandQuadrature> bands;
  std::vector<double> largest_reflectance;  ///< of any used curve at each grid point; 0.2 likewise
  std::vector<double>
      mean_reflectance;  ///< plain mean of the used curves on the grid; 0.2 in a scene without materials
};

/// What needs no air and no ray, added to `problems`: bands without a centre, a width or a response; used materials'
/// curves that begin too late or end too early for a band. Materials that nothing carries are not asked. curve_file: a
/// curve's file by its material's name, for messages, where the caller knows it.
void check_bands(const scene::Instrument& instrument, base::Problems& problems);
void check_curves(const scene::CompiledScene& scene, const scene::Instrument& instrument, base::Problems& problems,
                  const std::map<std::string, std::string>& curve_file = {});
/// Bands that leave a table's wavelengths. table_name: as messages name it.
void check_table(const scene::Instrument& instrument, const std::vector<double>& table_um,
                 const std::string& table_name, base::Problems& problems);

/// As messages name the air: a table's file, or the built-in model.
std::string table_name(const scene::Simulation& simulation);
/// Throws Error(input) when the view reaches further off nadir than the table. last_zenith_rad: of TableSpectra.
void check_view(const scene::Instrument& instrument, const ViewBounds& view, double last_zenith_rad);

/// Throws one Error(input) that names every band that leaves the table or a used material's curve. lamp_um: further
/// nodes of the grid.
SpectralPlan make_spectral_plan(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                const std::vector<double>& table_um, const std::string& table_name,
                                const std::vector<double>& lamp_um = {});

}  // namespace raycube::plan
