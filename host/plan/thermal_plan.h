// Thermal light of a scene with fixed temperatures: which temperatures there are, the surroundings that stand for
// whatever hides the sky, the temperature nodes, and what they need of the plan.
#pragma once

#include "host/base/error.h"
#include "host/plan/plan_errors.h"

namespace raycube::plan {

/// Temperatures of the scene's materials in use.
struct Emitters {
  std::vector<double> distinct_K;  ///< ascending
  double surroundings_K = 0;       ///< mean over the area of all placed triangles
};

/// `demanded_by`, what needs thermal light (temperature_demand): adds a problem for every used material without a
/// temperature. Empty: nothing.
void check_thermal_matter(const scene::CompiledScene& scene, const std::string& file, const std::string& demanded_by,
                          base::Problems& problems);

/// Throws one Error(input) that lists what check_thermal_matter finds. Where nothing demands thermal light, materials
/// without a temperature stand at 0 K and emit nothing. A scene without triangles takes the plain mean over its
/// materials, and 0 K without any.
Emitters find_emitters(const scene::CompiledScene& scene, const std::string& file, const std::string& demanded_by);

/// B at one temperature on a grid, W m-2 sr-1 um-1.
Spectrum planck_spectrum(const std::vector<double>& wavelength_um, double temperature_K);

/// One choice of temperature nodes and its error: in the worst band, the largest difference between B and its linear
/// interpolation midway between two nodes, as emitted radiance over typical radiance.
struct TemperatureLevel {
  std::vector<double> node_K;
  double error = 0;
};

/// Nodes evenly spread over the temperatures there are, 1, 2, 3, ... of them, and the temperatures themselves where
/// they are few enough: those leave no error. table_um: the covered part of the table's axis.
std::vector<TemperatureLevel> temperature_levels(const Emitters& emitters, const TableSpectra& air,
                                                 const Domain& domain, const BandSpace& bands,
                                                 const std::vector<double>& table_um,
                                                 const std::vector<double>& typical);

/// Where a temperature lies among the nodes: index + fraction, clamped.
double node_coordinate(const std::vector<double>& node_K, double temperature_K);

/// Adds the keys of what the used materials' fronts emit by the angle (RC_CURVE_LEANING) behind those of their curves:
/// none by Lambert's law.
void add_leaning_keys(const scene::CompiledScene& scene, std::vector<std::uint32_t>& keys);

/// Fills nodes, surfaces, maps, the table over tilt and those of lobes; factors: of the thermal sky, empty where it is
/// black.
Thermal make_thermal(const scene::CompiledScene& scene, const Emitters& emitters, const TemperatureLevel& nodes,
                     const SkyFactors& factors);

}  // namespace raycube::plan
