// MODTRAN's listing: .tp6, tape6. It repeats the input and says what became of it: of every line of sight the heights
// and angles (SUMMARY OF LINE-OF-SIGHT), where the sun stood along it (SINGLE SCATTER SOLAR PATH GEOMETRY TABLE), the
// day and the earth-sun factor. No spectra are read from it; it tells what a .chn, .acd or .csv of the same run lacks.
//
// The sun is that of the path's lower end for sights below the horizon, else that of the observer, refraction and all.
// Its azimuth from north is the path's "True Azimuth" plus the table's relative azimuth, both at the observer. Layout:
// MODTRAN 6.0 listings of isofit (Apache-2.0); MODTRAN 4 and 5 call the same lines H1, H2, ANGLE, RANGE and PHI.
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// One run per line of sight, mode "listing", without wavelengths.
Imported read_tape6(const std::string& path);

}  // namespace raycube::atmos::imported
