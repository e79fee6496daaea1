// libRadtran uvspec output with its input file, which alone names levels, angles and units.
//
// Without umu: one line per wavelength and level, `lambda edir edn eup uavgdir uavgdn uavgup` (disort) or `lambda edir
// edn eup uavg` (two-stream). With umu: the line, a line with the phi values when there are any, then `umu u0u uu(phi1)
// ...` per umu. With output_user: exactly the listed columns. Wavelength outer, level inner. edir is on the horizontal
// plane. Wavelengths are nm, taken as vacuum (1e7 / wavenumber in the same output). Negative numbers of diffuse light
// that is absent, no further below 0 than 1e-9 of the line's largest number, are rounding and read as 0.
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// The input of the output's name beside it, ending in .inp or .INP (as libRadtran's examples do); empty where there is
/// none.
std::string uvspec_input_beside(const std::string& path);

/// `input`: empty = the one beside it. One run: a column per quantity, level and direction.
Imported read_uvspec(const std::string& path, const std::string& input = {});

}  // namespace raycube::atmos::imported
