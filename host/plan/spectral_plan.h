// The spectral half of a plan: which curves count, whether every band can be served, the grid and the bands' weights.
#pragma once

#include "host/plan/plan.h"

namespace raycube::plan {

struct SpectralPlan {
  std::vector<double> wavelength_um;
  std::vector<BandQuadrature> bands;
  std::vector<double> largest_reflectance;  ///< of any used curve at each grid point; 0.2 likewise
  std::vector<double> mean_reflectance;  ///< plain mean of the used curves on the grid; 0.2 in a scene without materials
};

/// Throws one Error(input) that names every band that leaves the table or a used material's curve.
SpectralPlan make_spectral_plan(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                const std::vector<double>& table_um, const std::string& table_name);

}  // namespace raycube::plan
