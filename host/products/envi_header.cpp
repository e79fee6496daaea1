#include "host/products/envi_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cctype>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/text.h"

namespace raycube::products {
namespace {

constexpr std::array<EnviType, 11> kTypes = {{{1, 1, 1, "uint8"},
                                              {2, 2, 1, "int16"},
                                              {3, 4, 1, "int32"},
                                              {4, 4, 1, "float32"},
                                              {5, 8, 1, "float64"},
                                              {6, 8, 2, "complex64"},
                                              {9, 16, 2, "complex128"},
                                              {12, 2, 1, "uint16"},
                                              {13, 4, 1, "uint32"},
                                              {14, 8, 1, "int64"},
                                              {15, 8, 1, "uint64"}}};

/// Text that survives inside a list or a braced value.
std::string plain(std::string text, bool in_list) {
  for (char& c : text) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
    if (c == '{') c = '(';
    if (c == '}') c = ')';
    if (c == ',' && in_list) c = ';';
  }
  return text;
}

/// "key = {a, b, c}" with line breaks every few items.
template <class Items, class Format>
void append_list(std::string& out, const char* key, const Items& items, std::size_t per_line, Format format) {
  if (items.empty()) return;
  out += fmt::format("{} = {{", key);
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) out += ",";
    out += i % per_line == 0 && items.size() > per_line ? "\n  " : (i > 0 ? " " : "");
    out += format(items[i]);
  }
  out += "}\n";
}

/// Factor to micrometres of a unit that is proportional to wavelength; 0 when it is not.
double um_per_unit(const std::string& unit) {
  static const std::map<std::string, double> factors = {
      {"micrometers", 1},   {"micrometer", 1},   {"micrometres", 1},   {"micrometre", 1},    {"microns", 1},
      {"micron", 1},        {"um", 1},           {"\u00b5m", 1},       {"\u03bcm", 1},       {"\xb5m", 1},
      {"nanometres", 1e-3}, {"nanometre", 1e-3}, {"nanometers", 1e-3}, {"nanometer", 1e-3},  {"nm", 1e-3},
      {"millimeters", 1e3}, {"mm", 1e3},         {"cm", 1e4},          {"centimeters", 1e4}, {"m", 1e6},
      {"meters", 1e6},      {"angstroms", 1e-4}, {"angstrom", 1e-4}};
  const auto found = factors.find(base::lower_case(unit));
  return found == factors.end() ? 0 : found->second;
}

/// Of a unit that goes as one over wavelength: micrometres of one of it; 0 when it does not.
double um_over_unit(const std::string& unit) {
  static const std::map<std::string, double> factors = {{"wavenumber", 1e4}, {"wavenumbers", 1e4},
                                                        {"cm-1", 1e4},       {"cm^-1", 1e4},
                                                        {"1/cm", 1e4},       {"ghz", 299792.458},  // c, exact
                                                        {"mhz", 299792458.0}};
  const auto found = factors.find(base::lower_case(unit));
  return found == factors.end() ? 0 : found->second;
}

}  // namespace

Interleave parse_interleave(const std::string& text) {
  const std::string name = base::lower_case(text);
  if (name == "bsq") return Interleave::bsq;
  if (name == "bil") return Interleave::bil;
  if (name == "bip") return Interleave::bip;
  throw base::Error(base::Fault::input, "interleave must be bip, bil or bsq (found \"" + text + "\")");
}

const char* to_string(Interleave interleave) {
  return interleave == Interleave::bsq ? "bsq" : interleave == Interleave::bil ? "bil" : "bip";
}

const EnviType* find_envi_type(int code) {
  const auto found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const EnviType& type) { return type.code == code; });
  return found == kTypes.end() ? nullptr : &*found;
}

const EnviType& EnviHeader::type() const {
  if (const auto* found = find_envi_type(data_type)) return *found;
  throw base::Error(base::Fault::bug, fmt::format("ENVI has no data type {}", data_type));
}

std::uint64_t EnviHeader::data_bytes() const {
  return static_cast<std::uint64_t>(samples) * static_cast<std::uint64_t>(lines) * static_cast<std::uint64_t>(bands) *
         type().bytes;
}

bool EnviHeader::ignores(double stored) const {
  if (!data_ignore_value) return false;
  const double value = *data_ignore_value;
  if (stored == value) return true;
  if (data_type != 4 && data_type != 6) return false;
  const bool written_short = std::abs(value) > 1e30 && std::abs(stored - value) <= 1e-5 * std::abs(value);
  return written_short || (std::abs(value) <= 3.4e38 && stored == static_cast<double>(static_cast<float>(value)));
}

std::vector<double> EnviHeader::wavelength_um() const {
  std::vector<double> out;
  const double factor = um_per_unit(wavelength_units), over = um_over_unit(wavelength_units);
  if (factor == 0 && over == 0) return {};
  for (const double value : wavelength) out.push_back(factor > 0 ? value * factor : over / value);
  return out;
}

std::vector<double> EnviHeader::fwhm_um() const {
  const double factor = um_per_unit(wavelength_units), over = um_over_unit(wavelength_units);
  if (factor == 0 && (over == 0 || wavelength.size() != fwhm.size())) return {};
  std::vector<double> out = fwhm;
  for (std::size_t i = 0; i < out.size(); ++i)  // of wavenumbers and frequencies: between the band's ends
    out[i] =
        factor > 0 ? out[i] * factor : over / (wavelength[i] - 0.5 * out[i]) - over / (wavelength[i] + 0.5 * out[i]);
  return out;
}

double EnviHeader::scaled(double stored, std::size_t sample, std::size_t band) const {
  const auto of = [&](const std::vector<double>& list, double none) {
    return list.empty() ? none : !spectral_library ? list[band] : list.size() == 1 ? list[0] : list[sample];
  };
  return stored * of(data_gain, 1) + of(data_offset, 0);
}

std::string EnviHeader::why_no_wavelengths() const {
  if (wavelength.empty()) return "has no wavelengths";
  if (wavelength_units.empty()) return "has no 'wavelength units'";
  return "has wavelengths in no unit of them ('" + wavelength_units + "')";
}

std::string envi_header_text(const EnviHeader& h) {
  const auto number = [](double value) { return fmt::format("{:.10g}", value); };
  const auto exact = [](double value) { return fmt::format("{}", value); };
  const auto name = [](const std::string& text) { return plain(text, true); };
  std::string out = "ENVI\n";
  if (!h.description.empty()) out += fmt::format("description = {{{}}}\n", plain(h.description, false));
  out += fmt::format("samples = {}\nlines = {}\nbands = {}\nheader offset = {}\nfile type = {}\ndata type = {}\n",
                     h.samples, h.lines, h.bands, h.header_offset, h.file_type, h.data_type);
  out += fmt::format("interleave = {}\nbyte order = {}\n", to_string(h.interleave), h.byte_order);
  const auto line = [&](const char* key, const std::string& text) {
    if (!text.empty()) out += fmt::format("{} = {}\n", key, plain(text, false));
  };
  const auto value = [&](const char* key, const std::optional<double>& v) {
    if (v) out += fmt::format("{} = {}\n", key, *v);
  };
  line("sensor type", h.sensor_type);
  line("acquisition time", h.acquisition_time);
  value("sun azimuth", h.sun_azimuth_deg);
  value("sun elevation", h.sun_elevation_deg);
  line("data units", h.data_units);
  value("data ignore value", h.data_ignore_value);
  value("reflectance scale factor", h.reflectance_scale_factor);
  append_list(out, "map info", h.map_info, 64, name);
  if (!h.coordinate_system.empty())
    out += fmt::format("coordinate system string = {{{}}}\n", plain(h.coordinate_system, false));
  append_list(out, "default bands", h.default_bands, 64, [](int v) { return fmt::format("{}", v); });
  line("wavelength units", h.wavelength_units);
  append_list(out, "wavelength", h.wavelength, 8, number);
  append_list(out, "fwhm", h.fwhm, 8, number);
  append_list(out, "bbl", h.bad_bands, 32, [](int v) { return fmt::format("{}", v); });
  append_list(out, "data gain values", h.data_gain, 8, exact);
  append_list(out, "data offset values", h.data_offset, 8, exact);
  append_list(out, "band names", h.band_names, 4, name);
  append_list(out, "spectra names", h.spectra_names, 4, name);
  for (const auto& [key, text] : h.other) out += fmt::format("{} = {}\n", key, text);
  return out;
}

}  // namespace raycube::products
