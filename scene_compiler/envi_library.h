// ENVI spectral libraries (.sli with an ENVI header): one line per spectrum, one sample per wavelength.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::scene {

struct EnviLibrary {
  std::vector<double> wavelength_um;  ///< ascending where the file's descend
  std::vector<std::string> names;
  std::vector<std::vector<double>> spectra;  ///< gains and offsets applied; NaN: a bad band, or the ignore value
  std::optional<double> scale;  ///< on them: by "reflectance scale factor", else 0.01 where the header says percent
  std::string left_out;         ///< why samples are, by the header: "'bbl' marks 5 bands"
};

/// Reads the library at `file` (the data file), whose header is file with .hdr added or put in place of the extension,
/// by the reader of cubes (host/products/envi_reader.h) and all that it applies. nullopt after reporting what is wrong:
/// missing keys, a unit that is no wavelength's, truncated data, values that are no reflectance.
std::optional<EnviLibrary> read_envi_library(const std::string& file, const base::Where& asked_by,
                                             base::Problems& problems);

}  // namespace raycube::scene
