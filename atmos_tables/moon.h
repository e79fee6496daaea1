// The moon as a source: sunlight that it reflects, above the air at its mean distance. LOWTRAN7's figures
// (AFGL-TR-88-0177), good to 10-20 %; no surge beyond its phase table, no libration. Its own heat, which exceeds
// reflected sunlight beyond about
// 3 um, is not in it.
#pragma once

#include <string>

namespace raycube::atmos {

/// Irradiance from the moon over that from the sun, both on a plane normal to their beam:
/// 2.04472e-7 phase(angle) albedo(wavelength). phase_angle_deg: sun, moon, earth; 0 = full, 180 = new moon. The phase
/// table ends at 160 degrees with 0.002 (100 = full); from there it falls linearly to 0 at 180. wavelength_um: 0.3..30;
/// the albedo is held beyond 5 um. Throws Error(input) outside these ranges.
double moon_over_sun(double phase_angle_deg, double wavelength_um);

/// Short name of the source, for a table's header.
std::string moon_source_name();

}  // namespace raycube::atmos
