// What every built table starts from: checked inputs, and the table with its axes of wavelength and height and the
// sun's light.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "atmos_tables/solar_spectrum.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

/// Reports every input of build_clear_sky that breaks its range, as one Error(input).
void check_clear_sky(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                     const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m);

/// The part of it that holds for any built table: sun, sensor, wavelengths within first_um..last_um, heights.
void check_table_request(const scene::Sun& sun, double sensor_height_m, const std::vector<double>& wavelength_um,
                         const std::vector<double>& target_height_m, double first_um, double last_um);

/// Of a user's view zeniths: what breaks their rule, two or more, ascending, within 0..89.9 deg.
void check_view_zeniths(const std::vector<double>& view_zenith_deg);

/// Where the view zeniths of both built-in models end, unless the user gives others.
inline constexpr double kModelLastView_deg = 80;
/// Where those of a built table will end.
double last_view_zenith_deg(const scene::AtmosphereSpec& spec);

/// What a user should know of an instrument that begins at `first_um` and looks at reflected light under a sun or moon
/// below the horizon: it is dark, since the built-in models have no twilight. Nothing where light is up, thermal alone,
/// or a table of the user's.
std::optional<std::string> no_light_notice(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double first_um);

/// Wavelengths from low_um on in steps of step_um, high_um itself left out.
struct WavelengthSpan {
  double low_um, high_um, step_um;
};
/// Appends the span's part that lies within first_um..last_um, from the part's own beginning on.
void add_steps(std::vector<double>& wavelength_um, double first_um, double last_um, const WavelengthSpan& span);

/// The stretch that a wavelength node stands for: half way to its neighbours but at most 5 % away; the outer ones are
/// symmetrical, one node alone is a point.
struct NodeSpan {
  double from_um, to_um;
};
NodeSpan node_span(const std::vector<double>& wavelength_um, std::size_t i);

/// Wavelength and height axes and the row solar_irradiance: of a shipped spectrum, which is an average already, the
/// values at the nodes; of a file's the means over their spans.
RenderTable sunlit_table(const SolarSpectrum& solar, const scene::Sun& sun, double sensor_height_m,
                         const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m);

}  // namespace raycube::atmos
