// Measured spectra of a material: CSV and ENVI spectral libraries, checked and in vacuum micrometres.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

struct SpectrumRequest {
  std::string file;           ///< .csv, .sli with its header beside it, or as spectrometers write (spectrometer_file.h)
  std::string spectrum = {};  ///< name in a library; may be empty when it holds one
  std::string reflectance_column = "reflectance";
  std::string transmittance_column = "transmittance";
  std::optional<double> scale = {};  ///< on the file's values
  std::string wavelengths = {};      ///< file of them, where a library keeps them apart
  std::string medium = {};           ///< "air", "vacuum", or "" = as the file says
  base::Where asked_by = {};
};

/// Reads, converts and checks a spectrum; nullopt after reporting every kind of problem once. Samples without data
/// (not a number, or beyond 1e30 as USGS marks them) are left out, and `source` says how many. Rules: wavelengths
/// finite, strictly ascending, 0.05 to 1000 um (catches a wrong unit); at least two points; 0 <= r, t and r + t <=
/// 1. Files of spectrometers are sorted, their noise down to -0.05 counts as 0, values at one wavelength are
/// averaged. name is left empty.
std::optional<Material> read_spectrum(const SpectrumRequest& request, base::Problems& problems);

/// All spectra of a file, as opaque materials: each of a library, each column of a CSV beside the wavelength's. The
/// request's columns and name say nothing. Empty after reporting every problem.
std::vector<Material> read_family(const SpectrumRequest& request, base::Problems& problems);

/// Every spectrum that such a file holds, whatever columns and names are asked for: one of a spectrometer's file, and
/// of a CSV with reflectance and transmittance; else all of a library, or each column beside the wavelength's. Empty
/// after reporting every problem.
std::vector<Material> read_spectra(const SpectrumRequest& request, base::Problems& problems);

/// Unit of a wavelength column "wavelength_nm" or "wavelength_um" in um; nullopt for other names.
std::optional<double> wavelength_unit_um(const std::string& column);

/// A spectrum's value with the place in its file, for messages.
struct SpectrumPoint {
  double wavelength_um = 0, reflectance = 0, transmittance = 0;
  base::Where where;
};

/// The rules above; true when all points keep them. Reports each kind of problem once, with its number.
bool check_spectrum(const std::vector<SpectrumPoint>& points, const std::string& file, base::Problems& problems);

}  // namespace raycube::scene
