// The built-in layered model: profiles, band-model gases with k-terms, aerosols with Mie phase functions and the
// multiple-scattering solver fill a render table. docs/atmosphere.md says what it is made of and how good it is.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

inline constexpr double kLayeredFirst_um = 0.3, kLayeredLast_um = 30.0;
/// Tables that reach this far hold thermal rows: from here to 2.9 um the air absorbs so strongly that its own
/// light is most there is. Shorter tables leave that out: black air of 294 K emits 0.007 W m-2 sr-1 um-1
/// at 2.6 um.
inline constexpr double kThermalFrom_um = 2.6;

/// Most wavelengths of a table whose gases are resolved to lines: 1 nm in steps of 0.001 nm needs 1000.
inline constexpr std::size_t kMostResolvedNodes = 20000;

struct BuildWatch {
  int threads = 0;                                 ///< 0: all cores; cannot change a result
  std::function<void(std::size_t done)> finished;  ///< after every wavelength, from any thread; may throw to stop
};

/// Wavelengths ascending within 0.3..30 um; target heights ascending, m above z = 0, none above the sensor.
/// spec.layered must be set. From a sun zenith of 90 deg on the solar rows are 0, as there is no twilight
/// (clear_sky_inputs.h has the notice to give). Throws Error(input) with every problem found.
/// Where spec.layered names lines or cross-sections, the gases they hold are resolved at the wavelength nodes
/// themselves, not averaged over bins, and their band models are silent; the step between nodes is then the user's to
/// choose.
RenderTable build_layered(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                          const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m,
                          const BuildWatch& watch = {});

/// What build_layered refuses, without computing a table: profile and line files are read, the layers made.
void check_layered(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                   const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m);

/// Default grid of the range: 1 nm to 1 um, 2 nm to 2.5 um, 5 cm-1 beyond; step_um > 0 replaces all three.
std::vector<double> layered_wavelengths(double first_um, double last_um, double step_um = 0);

}  // namespace raycube::atmos
