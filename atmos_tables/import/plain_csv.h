// A user's own CSV: lines of `#` are comments; the first other row names the columns as `name [unit]`, the first of
// them `wavelength [um]`, `wavelength [nm]` or `wavenumber [cm-1]` (vacuum); then one row per wavelength, in order.
//
// Units: 1, K, um; radiance W m-2 sr-1 um-1, W cm-2 sr-1 um-1, uW cm-2 sr-1 nm-1, W cm-2 sr-1 (cm-1)-1; irradiance
// W m-2 um-1, W m-2 nm-1, mW m-2 nm-1, W cm-2 (cm-1)-1. Another unit is refused: nothing is guessed.
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

Imported read_plain_csv(const std::string& path);

}  // namespace raycube::atmos::imported
