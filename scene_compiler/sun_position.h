// Where the sun and the moon are, from date, time and place.
#pragma once

#include <string>

#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Sun seen from latitude_deg (north positive, -90..90) and longitude_deg (east positive, -180..360) at `utc`
/// ("2012-09-20T15:30:00Z", seconds may have a fraction, years 1900..2100). Apparent place from libnova (VSOP87,
/// nutation, Delta T) with precession and light time added; without refraction and without parallax (0.0024 degrees at
/// the horizon). Good to 0.004 degrees. Throws Error(input).
Sun sun_from_time(const std::string& utc, double latitude_deg, double longitude_deg);

/// The moon likewise: direction from libnova (ELP 2000), moved by its parallax at sea level (up to 1 degree), and its
/// phase angle. Good to 0.02 degrees. Throws Error(input).
Sun moon_from_time(const std::string& utc, double latitude_deg, double longitude_deg);

/// libnova counts azimuth from south over west; raycube from north over east. Degrees, result 0..360.
double azimuth_from_libnova_deg(double libnova_azimuth_deg);

}  // namespace raycube::scene
