// Lamps as a plan has them.
#pragma once

#include <string>
#include <vector>

#include "host/plan/plan.h"
#include "host/plan/sources.h"
#include "host/plan/spectral_plan.h"
#include "scene_compiler/lamp.h"

namespace raycube::plan {

/// Nodes of the lamps' spectra, um, for the plan's grid, and just beyond their ends.
std::vector<double> lamp_nodes_um(const std::vector<scene::Lamp>& lamps);

/// Records, sources and their spectra on the plan's grid. Those whose light no band of the instrument sees are left
/// out, and a notice says so.
Lamps make_lamps(const std::vector<scene::Lamp>& lamps, const SpectralPlan& spectral, const std::string& instrument,
                 std::vector<std::string>& notices);

/// Spectral irradiance if their light fell evenly onto the scene's extent on the map, W m-2 um-1: what errors are
/// weighed by. On the wavelengths given; empty without lamps.
Spectrum typical_lamplight(const std::vector<scene::Lamp>& lamps, const scene::CompiledScene& scene,
                           const std::vector<double>& wavelength_um);

}  // namespace raycube::plan
