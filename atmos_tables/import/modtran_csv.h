// MODTRAN 6 CSV: spectra and fluxes.
//
// Spectra: a row of labels that starts with Freq, one row per frequency; other rows without numbers are skipped, except
// that a unit in the first cell below the labels ("cm-1", "nm") names the axis. Fluxes: per case `case index N = {`,
// `num freq, N`, `num column, M`, labels `Freq, UP, DOWN, SOLAR, UP, ...`, a row with the axis's unit and each column's
// level ("1 KM"), numbers, `}`; UP and DOWN are diffuse, SOLAR is direct, all on a horizontal plane, W cm-2 (cm-1)-1.
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// Either kind, told apart by `case index`.
Imported read_modtran_csv(const std::string& path);

}  // namespace raycube::atmos::imported
