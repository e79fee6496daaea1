// What one file of a MODTRAN run tells of another: a .chn, .acd or .csv names neither sun nor heights nor day, and the
// listing (.tp6) and the input (JSON) of the same run do.
#pragma once

#include <vector>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// Fills what runs of MODTRAN in `files` leave open of their geometry, from the listings and inputs among `files`: that
/// of the same name (X.chn, X.tp6), else the only one there is; and from X.tp6 or X.json beside X.chn, X.acd or X.csv
/// where none was given. The runs are taken in order, or one told line of sight serves all. Notes in the runs say where
/// their geometry is from. Throws Error(input) where a file's own geometry contradicts what is told (0.05 deg, 0.5 m),
/// or the numbers of lines of sight differ.
void tell_geometry(std::vector<Imported>& files);

/// How the note begins that says whose geometry a run has; the file's name follows.
inline constexpr const char* kToldBy = "sun, heights and day as told by ";

/// Whether a run is a listing's or an input's: it holds geometry and no spectra.
bool only_tells(const Run& run);

}  // namespace raycube::atmos::imported
