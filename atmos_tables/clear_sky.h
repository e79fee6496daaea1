// The built-in clear sky: fills a render table from published figures. Transmittances and diffuse irradiance of Bird &
// Riordan (1986), Rayleigh depth of Bodhaine et al. (1999), Angstrom aerosol with a Henyey-Greenstein phase function,
// layers of air_column.h. Directions come from exact single scattering per layer; multiple scattering is a correction:
//   sky   scaled per wavelength and height so that its horizontal irradiance equals Bird & Riordan's diffuse irradiance
//   path  plus the light that the diffuse fluxes down (Bird & Riordan) and up (their energy balance) scatter into it
// docs/table_format.md states what this is worth against DISORT and MODTRAN. 0.3 to 4 um; no thermal emission.
#pragma once

#include <vector>

#include "atmos_tables/render_table.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

inline constexpr double kClearSkyFirst_um = 0.3, kClearSkyLast_um = 4.0;

/// Wavelengths ascending within 0.3..4 um. Target heights ascending, m above z = 0, none above the sensor; one height
/// states that the scene is flat. sensor_height_m may lie on the ground, inside or above the air.
/// From a sun zenith of 90 deg on the sky is dark, as twilight is not modelled: the solar rows are exactly 0 but for
/// the sun above the air (clear_sky_inputs.h has the notice to give). Throws Error(input) with every problem found.
RenderTable build_clear_sky(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                            const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m);

inline constexpr double kVacuumLast_um = 1000;

/// No air: every transmission is exactly 1, sky and path radiance exactly 0, which is the physics of vacuum.
/// 0.3 to 1000 um: from where the sun's spectrum is known; what surfaces emit is not the table's to say.
RenderTable vacuum_table(const scene::Sun& sun, double sensor_height_m, const std::vector<double>& wavelength_um,
                         const std::vector<double>& target_height_m, const scene::SolarSpectrumSpec& spectrum = {});

/// What a simulation names: the file, no air, or the clear sky. A table read from a file must fit the sun (0.01 deg)
/// and the sensor height (0.1 m) asked for.
RenderTable make_table(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                       const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m);

/// Default grid of the range: 1 nm to 1 um, 2 nm to 2.5 um, 10 nm beyond; step_um > 0 replaces all three.
std::vector<double> clear_sky_wavelengths(double first_um, double last_um, double step_um = 0);

/// The same for vacuum: 10 nm to 10 um, 50 nm to 100 um, 500 nm beyond.
std::vector<double> vacuum_wavelengths(double first_um, double last_um, double step_um = 0);

/// Heights over [low_m, high_m], both ends and 150 m steps (at most 16 nodes): transmissions between them within 0.2 %,
/// in saturated bands within 1.3 % of the depth 235 m from the sensor. One height when the two are equal.
std::vector<double> clear_sky_heights(double low_m, double high_m);

}  // namespace raycube::atmos
