// The header of an ENVI file: what it says, reading it and writing it. Keys as in the ENVI documentation ("ENVI Header
// Files", L3Harris); wavelength units written are exactly `Micrometers` or `Nanometers`, which every tool accepts.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace raycube::products {

enum class Interleave { bsq, bil, bip };
Interleave parse_interleave(const std::string& text);  ///< either case; Error(input) for anything else
const char* to_string(Interleave interleave);

/// One of ENVI's pixel types.
struct EnviType {
  int code;           ///< value of the key `data type`
  std::size_t bytes;  ///< of one sample; complex: both parts
  int components;     ///< 1, complex 2
  const char* name;   ///< "float32"
};
/// The type of a code, null when ENVI has none such.
const EnviType* find_envi_type(int code);

struct EnviHeader {
  std::int64_t samples = 0, lines = 0, bands = 0;
  std::uint64_t header_offset = 0;  ///< bytes before the first sample
  std::string file_type = "ENVI Standard";
  bool spectral_library = false;  ///< a spectrum in each line, a wavelength for each sample; settled as it is read
  int data_type = 4;
  Interleave interleave = Interleave::bip;
  int byte_order = 0;  ///< 0 little endian, 1 big endian
  std::string description, sensor_type, data_units;
  std::string acquisition_time;                              ///< ISO 8601, UTC
  std::optional<double> sun_azimuth_deg, sun_elevation_deg;  ///< azimuth clockwise from north
  std::string wavelength_units;                              ///< as in the file
  std::vector<double> wavelength, fwhm;  ///< in wavelength_units, one per band (spectral library: per sample)
  std::vector<int> bad_bands;            ///< key bbl: 1 good, 0 bad
  std::vector<std::string> band_names, spectra_names;
  std::vector<int> default_bands;  ///< 1-based as in the file: red, green, blue or one
  std::vector<double> data_gain,
      data_offset;  ///< physical = stored * gain + offset, per band (library: sample, or one)
  std::optional<double> data_ignore_value;
  std::optional<double> reflectance_scale_factor;
  std::vector<std::string> map_info;         ///< items; reference pixel (1, 1) is the upper left corner
  std::string coordinate_system;             ///< ESRI WKT
  std::map<std::string, std::string> other;  ///< every other key, lower case, with its text as it stands
  std::vector<std::string> warnings;         ///< what reading had to leave out, one sentence each

  const EnviType& type() const;      ///< Error(bug) for an unknown code
  std::uint64_t data_bytes() const;  ///< samples * lines * bands * sample size
  /// Whether a stored number is the data ignore value: as the file's type holds it, and as headers write the largest
  /// floats, in six digits.
  bool ignores(double stored) const;
  /// Wavelengths in micrometres; empty when there are none or their unit is no wavelength (Index, Unknown).
  std::vector<double> wavelength_um() const;
  std::vector<double> fwhm_um() const;
  /// What a stored number stands for by gain and offset: those of its band, of a library's sample.
  double scaled(double stored, std::size_t sample, std::size_t band) const;
  /// Why wavelength_um() is empty, as the end of a sentence on the header: "has no wavelengths".
  std::string why_no_wavelengths() const;
};

/// Parses header text; file is for messages. Keys in any case, lists over several lines, CR LF, comments (;). Throws
/// one Error(input) that lists every problem: not ENVI, missing keys, bad or absurd numbers, open braces.
EnviHeader parse_envi_header(const std::string& text, const std::string& file);

/// Reads and parses a header file.
EnviHeader read_envi_header(const std::string& path);

/// Header text. Commas, braces and line breaks inside names, which ENVI cannot hold, become ; ( ) and spaces.
std::string envi_header_text(const EnviHeader& header);

}  // namespace raycube::products
