// Text output of 6S (4.1) and 6SV: one spectral band per run, or a table by wavelength (iwave = -2); runs may
// follow each other in one file. Of a run with a table the table is read, and what the run says of its whole
// range, optical depths among it, is not.
//
// Read are band, angles, sun's azimuth, ground and aircraft, apparent reflectance and radiance, gas and scattering
// transmittances (down, up, total), spherical albedo, optical depths, irradiances at the ground, the parts of the
// radiance, and the solar irradiance in the band or, of a monochromatic run, at its wavelength. Angles: azimuth
// difference 0 is the sun's side (backscatter), as here. The apparent reflectance must be pi L / (E0 cos sun).
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// A band's wavelength is its middle; columns band_first and band_last hold its ends.
Imported read_sixs(const std::string& path);

}  // namespace raycube::atmos::imported
