// An instrument's bands: centre and FWHM lists, tabulated responses, regular grids.
#pragma once

#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Reads a CSV of bands. Forms, told by the header:
///   center_nm,fwhm_nm (or _um; optional name)        Gaussian bands
///   wavelength_nm,<band>,<band>,...  (or _um)        one response column per band, >= 0, ascending
///   wavelengths band,wavelength_nm,response      (or _um)        the same, one row per sample, bands in
///   blocks
/// medium "air", "vacuum" or "" (what the file's `# medium:` line says, else vacuum). Centres of tabulated
/// bands are the response-weighted mean wavelengths. Result in file order; reports every bad row.
std::vector<Band> read_band_file(const std::string& file, const std::string& medium, const base::Where& asked_by,
                                 base::Problems& problems);

/// count Gaussian bands at first_nm + i step_nm.
std::vector<Band> regular_bands(double first_nm, double step_nm, int count, double fwhm_nm, const std::string& medium);

/// Sorts by centre, stable (duplicates and overlaps stay); true when the order changed.
bool sort_bands(std::vector<Band>& bands);

}  // namespace raycube::scene
