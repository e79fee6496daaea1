// MODTRAN 4, 5 and 6 tape7 / .tp7 and its slit-convolved twin .7sc / tape7.scn, text.
//
// Runs follow each other in one file: an echo of the input cards, a header that starts with FREQ (or WAVLEN), data, and
// a line with -9999. Three layouts: transmittances (two header lines, split on blanks), radiances (fields not computed
// are blank, so they are cut at the ends of the header's labels, where every number ends), and direct irradiance (split
// on blanks; a trailing optical depth without label). Fixed-width echo lines are never data. Units by axis: W cm-2
// [sr-1] per cm-1, um or nm.
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// Throws base::Error(input) with every problem as file:line. `format`: "tape7" or "7sc"; both have one layout.
Imported read_tape7(const std::string& path, const std::string& format = "tape7");

}  // namespace raycube::atmos::imported
