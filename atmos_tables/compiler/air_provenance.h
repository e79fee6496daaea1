// What the provenance of every table of the layered model says of its air: one list for tables and LIDAR
// profiles.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

/// "ground_height_m", "profile", "profile_file" (null: none), "aerosol", "visibility_km" (null without
/// aerosol), "aod_550" and where that is from: "stated", "visibility", "own aerosols" or "no aerosol"; where there
/// are any, of each of "own_aerosols" what the user stated.
nlohmann::json air_parameters(const scene::AtmosphereSpec& spec, const AerosolColumn& aerosols);

/// Where the optics of the aerosols are from, in words.
std::string aerosol_source(const scene::AirSpec& air);

/// What profiles for LIDAR without a line list leave out.
struct GasesLeftOut {
  std::string text;  ///< a notice, with the share at the wavelength where it is largest
  double share = 0;  ///< 0..1
};

/// Share of the light from which absorption by gases that is left out is worth a warning.
inline constexpr double kTellsGases = 0.05;

/// The light that gases take on the way straight up from the ground through all the air of `spec`, by the
/// band models and continua of the layered model: means over 20 cm-1, which say how much there is to lose but
/// not how much a laser's line loses of it.
GasesLeftOut gases_left_out(const scene::AirSpec& spec, double ground_km, const std::vector<double>& wavelength_um);

}  // namespace raycube::atmos
