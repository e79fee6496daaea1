// Reflectance spectra as laboratories, field spectrometers and spectral libraries hand them out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::scene {

/// What such a file says, in its own order.
struct SpectrometerFile {
  std::string kind;                          ///< "ECOSTRESS", "USGS splib06" ...
  std::string name;                          ///< of the sample, as it calls it
  std::vector<double> wavelength_um, value;  ///< value: times `scale` a reflectance
  std::vector<int> line;                     ///< of each in the file; 0: none, it is binary
  double scale = 1;                          ///< 0.01: percent
  std::size_t decimal_commas = 0;            ///< lines whose numbers have some
  std::vector<int> unread;                   ///< lines behind the first row that are none
};

/// Kinds are told by what stands in them, whatever their names:
///   ECOSTRESS and ASTER text    "X Units: Wavelength (micrometers)", "Y Units: Reflectance (percent)", two columns
///   USGS splib06 text (.asc)    "USGS Digital Spectral Library", three columns from micrometres on
///   USGS splib07 text           "splib07...", one value a line; wavelengths: that library's file of wavelengths, um
///   ASD binary (.asd)           as its FieldSpecs write them, versions 6 to 8: target over white reference
///   ASD text                    "Wavelength" and the sample's name, or ASD's header as text; two columns, nm
///   SVC (.sig)                  "Spectra Vista", four columns after "data=": nm, reference, target, percent
/// Text that names its values "%" or "percent" where it names them has scale 0.01.
/// nullopt without a report: none of these (`known` is false then), or after reporting what is wrong.
std::optional<SpectrometerFile> read_spectrometer_file(const std::string& file, const std::string& wavelengths,
                                                       const base::Where& asked_by, bool& known,
                                                       base::Problems& problems);

}  // namespace raycube::scene
