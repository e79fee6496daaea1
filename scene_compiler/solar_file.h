// The sun's spectrum of a user's file.
#pragma once

#include <optional>
#include <string>

#include "host/base/error.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// A CSV of irradiance at 1 AU above the air against wavelength (vacuum), ascending, with a header. Units are those in
/// the names of the columns: wavelength_nm or wavelength_um; irradiance_W_m2_um, irradiance_W_m2_nm or
/// irradiance_mW_m2_nm, or extraterrestrial with one of these endings. The bare names wavelength, irradiance and
/// extraterrestrial, as in tables of ASTM G173, take them from comment lines: "wavelength in nm" or "in um", "W m-2
/// nm-1", "mW m-2 nm-1", "W m-2 um-1". Other columns are left out. nullopt after reporting every problem.
std::optional<SolarSpectrumSpec> read_solar_spectrum(const std::string& file, const base::Where& asked_by,
                                                     base::Problems& problems);

}  // namespace raycube::scene
