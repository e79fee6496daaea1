#include "scene_compiler/envi_library.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/products/envi_reader.h"
#include "host/products/radiance_unit.h"
#include "host/base/text.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

using base::Problems;
using products::EnviHeader;

/// What the reader of headers said of a key that it left out, or `other`.
std::string said_of(const std::string& key, const EnviHeader& header, const std::string& other) {
  for (const std::string& warning : header.warnings)
    if (warning.find('"' + key + '"') != std::string::npos) return warning;
  return other;
}

/// Whether the header describes spectra of reflectance.
bool check_header(const EnviHeader& header, const std::string& file, Problems& problems) {
  const std::size_t before = problems.count();
  const base::Where where{file, 0, 0, ""};
  if (header.type().components != 1)
    problems.add(where, "ENVI data type is not a real number's", std::to_string(header.data_type), "convert to 4 or 5");
  if (header.bands != 1)
    problems.add(where, "a spectral library has one band", std::to_string(header.bands),
                 "make a library of it: a line for each spectrum, a sample for each wavelength");
  if (header.wavelength.empty())
    problems.add(where, "ENVI header lacks 'wavelength'", said_of("wavelength", header, ""),
                 "add it, a number for each sample");
  else if (header.wavelength_units.empty())
    problems.add(where, "ENVI header lacks 'wavelength units'", "", "add it, like Micrometers or Nanometers");
  else if (header.wavelength_um().empty())
    problems.add(where, "unknown wavelength unit", header.wavelength_units, "write Micrometers or Nanometers");
  if (header.spectra_names.empty())
    problems.add(where, "ENVI header has no name for each spectrum", said_of("spectra names", header, ""),
                 "add 'spectra names', one for each of " + std::to_string(header.lines) + " lines");
  if (header.reflectance_scale_factor && !(*header.reflectance_scale_factor > 0))
    problems.add(where, "'reflectance scale factor' is not a positive number",
                 number_text(*header.reflectance_scale_factor), "give a number > 0");
  const std::string units = lower_case(header.data_units);
  for (const char* other : {"radiance", "transmittance", "absorbance", "emissivity"})
    if (units.find(other) != std::string::npos || products::radiance_of(header.data_units)) {
      problems.add(where, "a spectral library that is not of reflectance", header.data_units,
                   "use one of reflectance, or correct 'data units'");
      break;
    }
  return problems.count() == before;
}

std::optional<double> scale_of(const EnviHeader& header) {
  if (header.reflectance_scale_factor) return 1 / *header.reflectance_scale_factor;
  const auto titles = header.other.find("z plot titles");
  if (says_percent(header.data_units) || (titles != header.other.end() && says_percent(titles->second))) return 0.01;
  return std::nullopt;
}

/// A number for each sample, from a list of as many, or of one for all.
double of_sample(const std::vector<double>& list, std::size_t sample, double other) {
  return list.empty() ? other : list.size() == 1 ? list[0] : list[sample];
}

EnviLibrary library_of(const products::EnviReader& reader, const std::string& file, Problems& problems) {
  const EnviHeader& h = reader.header();
  const auto samples = static_cast<std::size_t>(h.samples), lines = static_cast<std::size_t>(h.lines);
  EnviLibrary out{h.wavelength_um(), h.spectra_names, {}, scale_of(h), {}};
  std::size_t ignored = 0;
  for (std::size_t line = 0; line < lines; ++line) {
    std::vector<double>& spectrum = out.spectra.emplace_back(reader.read_lines(static_cast<std::int64_t>(line), 1));
    for (std::size_t i = 0; i < samples; ++i) {
      const bool no_data = h.ignores(spectrum[i]);
      ignored += no_data;
      if (no_data || (!h.bad_bands.empty() && h.bad_bands[i] == 0))
        spectrum[i] = NAN;
      else
        spectrum[i] = spectrum[i] * of_sample(h.data_gain, i, 1) + of_sample(h.data_offset, i, 0);
    }
  }
  const auto bad = std::count(h.bad_bands.begin(), h.bad_bands.end(), 0);
  const base::Where where{file, 0, 0, ""};
  if (bad > 0) out.left_out = "'bbl' marks " + base::counted(static_cast<std::size_t>(bad), "band");
  if (ignored > 0)
    out.left_out += (bad > 0 ? ", " : "") + base::counted(ignored, "number") + " of the ignore value " +
                    number_text(*h.data_ignore_value);
  if (!h.data_gain.empty() || !h.data_offset.empty())
    problems.tell(where, "values are the file's numbers by its 'data gain values' and 'data offset values'");
  if (samples > 1 && std::is_sorted(out.wavelength_um.rbegin(), out.wavelength_um.rend())) {
    std::reverse(out.wavelength_um.begin(), out.wavelength_um.end());
    for (std::vector<double>& spectrum : out.spectra) std::reverse(spectrum.begin(), spectrum.end());
  }
  return out;
}

}  // namespace

std::optional<EnviLibrary> read_envi_library(const std::string& file, const base::Where& asked_by, Problems& problems) {
  if (!check_readable(file, asked_by, problems)) return std::nullopt;
  try {
    const products::EnviReader reader(file);
    for (const std::string& warning : reader.header().warnings) problems.tell({}, warning);
    if (!check_header(reader.header(), reader.paths().header, problems)) return std::nullopt;
    return library_of(reader, file, problems);
  } catch (const base::Error& error) {
    if (error.fault() != base::Fault::input) throw;
    std::istringstream lines(error.what());
    for (std::string line; std::getline(lines, line);) problems.add({}, line, "", "");
    return std::nullopt;
  }
}

}  // namespace raycube::scene
