// Spectra that an analysis looks for or takes apart into: means of regions, or curves of files on a cube's bands.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/cube.h"

namespace raycube::analysis {

struct NamedSpectrum {
  std::string name;
  Eigen::VectorXd value;  ///< on the cube's bands that take part
  std::string source;     ///< what was asked for, as written
};

/// Whether what is written is a curve's file, with or without @ and a name in it.
bool is_curve_file(const std::string& what);

/// Reads spectra written as NAME=WHAT: WHAT is a region of the cube (read_region), whose mean is taken, or a file of
/// reflectances: FILE.csv (wavelength_nm and reflectance; of several columns FILE.csv@COLUMN), FILE.sli@NAME of an ENVI
/// library. A file's curve is averaged over each band's Gaussian response of the header's full width at half maximum,
/// or taken at its centre where the header has none. Throws Error(input): unknown text, a name that comes twice, a
/// curve that does not reach over the bands.
std::vector<NamedSpectrum> read_spectra(const std::vector<std::string>& texts, const Cube& cube, const Pass& pass);

}  // namespace raycube::analysis
