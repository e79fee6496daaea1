// ENVI spectral libraries (.sli with an ENVI header): one line per spectrum, one sample per wavelength.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::scene {

struct EnviLibrary {
  std::string header_file;
  std::vector<double> wavelength_um;
  std::vector<std::string> names;
  std::vector<std::vector<double>> spectra;  ///< as stored, unscaled
  double scale_factor = 1;                   ///< "reflectance scale factor": stored = fraction x this
};

/// Reads the library at `file` (the data file); its header is file with .hdr added or put in place of the
/// extension. Handles byte orders 0 and 1, ENVI data types 1, 2, 3, 4, 5, 12, 13, 14, 15, header offset, and
/// wavelength units Micrometers, Nanometers (and um, nm). nullopt after reporting what is wrong: missing
/// keys, unknown unit, truncated data.
std::optional<EnviLibrary> read_envi_library(const std::string& file, const base::Where& asked_by,
                                             base::Problems& problems);

}  // namespace raycube::scene
