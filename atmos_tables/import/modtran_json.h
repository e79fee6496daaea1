// MODTRAN 6 JSON output: MODTRAN[i].MODTRANOUTPUT.SPECTRA.<kind>, arrays of one length headed by FREQ. One run per case
// and kind. The axis's unit and the geometry come from the MODTRANINPUT beside it. Of an input without output: one run
// per case, mode "input", of what its GEOMETRY and SURFACE say (heights, sun, day), without wavelengths. Values have no
// lines; messages name the JSON place ("MODTRAN[0].MODTRANOUTPUT.SPECTRA.RADIANCE.TOT_TRANS[17]"), a broken text its
// line and column.
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

Imported read_modtran_json(const std::string& path);

}  // namespace raycube::atmos::imported
