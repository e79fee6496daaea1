#include "scene_compiler/spectrometer_file.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <set>
#include <sstream>

#include "host/base/text.h"
#include "scene_compiler/csv_file.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

/// Whether a comma of a line of numbers is a decimal one, as half of Europe writes: between two digits, beside numbers
/// that blanks, tabs or semicolons part.
bool is_decimal_comma(const std::string& line, std::size_t at) {
  const auto is_digit = [&](std::size_t i) { return std::isdigit(static_cast<unsigned char>(line[i])) != 0; };
  return line[at] == ',' && at > 0 && at + 1 < line.size() && is_digit(at - 1) && is_digit(at + 1) &&
         line.find_first_of("\t; ") != std::string::npos;
}

/// Numbers that a line begins with, between blanks, tabs, semicolons, or commas that are none of decimals. None where
/// the line begins otherwise.
std::vector<double> numbers_of(const std::string& text) {
  std::string line = text;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (is_decimal_comma(text, i))
      line[i] = '.';
    else if (line[i] == '\t' || line[i] == ';' || line[i] == ',')
      line[i] = ' ';
  std::vector<double> out;
  std::istringstream cells(line);
  for (std::string word; cells >> word;) {
    const auto number = parse_number(word);
    if (!number) return out;
    out.push_back(*number);
  }
  return out;
}

bool has_decimal_comma(const std::string& line) {
  for (std::size_t i = 0; i < line.size(); ++i)
    if (is_decimal_comma(line, i)) return true;
  return false;
}

struct TextFile {
  std::string file;
  std::vector<std::string> lines;

  bool has(const std::string& text, std::size_t within) const {
    for (std::size_t i = 0; i < std::min(within, lines.size()); ++i)
      if (lower_case(lines[i]).find(text) != std::string::npos) return true;
    return false;
  }
  /// Whether it has a CSV's header: then it is that, whatever its comments name.
  bool is_csv() const {
    for (const std::string& line : lines) {
      if (line.empty() || line[0] == '#') continue;
      const std::string header = lower_case(line);
      return header.find("wavelength_nm") != std::string::npos || header.find("wavelength_um") != std::string::npos;
    }
    return false;
  }
  /// What follows "key:" in the header.
  std::string value(const std::string& key) const {
    for (std::size_t i = 0; i < std::min<std::size_t>(200, lines.size()); ++i)
      if (lower_case(lines[i]).starts_with(key + ":")) return trimmed(lines[i].substr(key.size() + 1));
    return "";
  }
};

TextFile lines_of(const std::string& file, const std::string& text) {
  TextFile out{file, {}};
  std::istringstream stream(base::without_dos_end(text));
  for (std::string line; std::getline(stream, line);) out.lines.push_back(trimmed(line));
  return out;
}

/// Columns of numbers from line `first` on, which is behind the header, `of` them in a row; unit: of the first, in um.
SpectrometerFile columns(const TextFile& text, std::size_t first, std::size_t column, double unit, std::size_t of) {
  SpectrometerFile out;
  for (std::size_t i = first; i < text.lines.size(); ++i) {
    const std::vector<double> numbers = numbers_of(text.lines[i]);
    if (numbers.size() != of) {
      if (!text.lines[i].empty() && (!out.value.empty() || !numbers.empty()))
        out.unread.push_back(static_cast<int>(i) + 1);
      continue;
    }
    out.decimal_commas += has_decimal_comma(text.lines[i]);
    out.wavelength_um.push_back(numbers[0] * unit), out.value.push_back(numbers[column]);
    out.line.push_back(static_cast<int>(i) + 1);
  }
  return out;
}

std::optional<SpectrometerFile> ecostress(const TextFile& text, Problems& problems) {
  const std::string x = lower_case(text.value("x units")), y = lower_case(text.value("y units"));
  const bool um = x.find("micromet") != std::string::npos || x.find("micron") != std::string::npos;
  if (!um && x.find("nanomet") == std::string::npos) {
    problems.add({text.file, 0, 0, "X Units"}, "unknown unit of wavelengths", x.empty() ? "none" : x,
                 "give micrometers or nanometers");
    return std::nullopt;
  }
  if (y.find("reflectance") == std::string::npos) {
    problems.add({text.file, 0, 0, "Y Units"}, "no reflectance", y.empty() ? "none" : y,
                 "use a file of reflectance, or write a CSV");
    return std::nullopt;
  }
  std::size_t last_key = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(200, text.lines.size()); ++i)
    if (numbers_of(text.lines[i]).size() < 2 && text.lines[i].find(':') != std::string::npos) last_key = i;
  SpectrometerFile out = columns(text, last_key + 1, 1, um ? 1 : 1e-3, 2);
  const auto declared = parse_number(text.value("number of x values"));
  if (declared && *declared != static_cast<double>(out.value.size())) {
    problems.add({text.file, 0, 0, "Number of X Values"}, "the file holds another number of rows",
                 std::to_string(out.value.size()) + " for " + text.value("number of x values"),
                 "restore the file, or correct its header");
    return std::nullopt;
  }
  out.kind = "ECOSTRESS", out.name = text.value("name");
  if (says_percent(y)) out.scale = 0.01;
  return out;
}

SpectrometerFile splib06(const TextFile& text) {
  SpectrometerFile out = columns(text, 15, 1, 1, 3);
  out.kind = "USGS splib06";
  if (text.lines.size() > 14) out.name = text.lines[14];
  return out;
}

/// Values alone; wavelengths stand in a file of their own, like these.
std::optional<SpectrometerFile> splib07(const TextFile& text, const std::string& wavelengths, const Where& asked_by,
                                        Problems& problems) {
  if (wavelengths.empty()) {
    problems.add(asked_by, "a spectrum of splib07 stands without its wavelengths", text.file,
                 "name the library's file of them with `wavelengths` (splib07a_Wavelengths_..._microns_...txt)");
    return std::nullopt;
  }
  const auto other = read_whole_file(wavelengths, asked_by, problems);
  if (!other) return std::nullopt;
  const TextFile places = lines_of(wavelengths, *other);
  const auto values = columns(text, 1, 0, 1, 1), at = columns(places, 1, 0, 1, 1);
  if (values.value.size() != at.value.size()) {
    problems.add({wavelengths, 0, 0, ""}, "not the wavelengths of " + text.file,
                 std::to_string(at.value.size()) + " for " + base::counted(values.value.size(), "value"),
                 "name those of the same spectrometer");
    return std::nullopt;
  }
  SpectrometerFile out = values;
  out.kind = "USGS splib07", out.name = text.lines.empty() ? "" : text.lines[0];
  out.wavelength_um = at.value;
  return out;
}

std::optional<SpectrometerFile> sig(const TextFile& text, Problems& problems) {
  for (std::size_t i = 0; i < text.lines.size(); ++i) {
    if (!lower_case(text.lines[i]).starts_with("data=")) continue;
    SpectrometerFile out = columns(text, i + 1, 3, 1e-3, 4);
    out.kind = "SVC", out.scale = 0.01;
    for (const std::string& line : text.lines)
      if (lower_case(line).starts_with("name=")) out.name = trimmed(line.substr(5));
    return out;
  }
  problems.add({text.file, 0, 0, ""}, "a file of an SVC spectrometer without data", "no line 'data='",
               "export it again");
  return std::nullopt;
}

/// The line of an ASD text that names its columns, the last one before its numbers; nullopt: none does.
std::optional<std::size_t> asd_names_line(const TextFile& text) {
  std::optional<std::size_t> out;
  for (std::size_t i = 0; i < text.lines.size() && numbers_of(text.lines[i]).size() < 2; ++i)
    if (lower_case(text.lines[i]).starts_with("wavelength")) out = i;
  return out;
}

/// Of wavelengths, by the name of their column: nm, as ASD writes them, unless it has another unit as a word:
/// micrometres, or one that is not read (0, and `unknown` says it). A name ends at a tab, a semicolon or a comma.
double asd_unit_um(const std::string& names, std::string& unknown) {
  static const std::set<std::string> kNm = {"nm", "nanometer", "nanometers", "nanometre", "nanometres"},
                                     kUm = {"um",          "\u00b5m",    "\u03bcm",     "\xb5m",  "micrometer",
                                            "micrometers", "micrometre", "micrometres", "micron", "microns"},
                                     kNone = {"in", "of", "air", "vacuum", "the", "units", "unit", "s"};
  constexpr std::size_t kWord = 10;  // "wavelength"
  std::string name = lower_case(names);
  if (!name.starts_with("wavelength")) return 1e-3;
  const std::size_t end = name.find_first_of(";\t,");
  name = name.substr(kWord, end == std::string::npos ? end : end - kWord);
  // Blanks alone may part columns: then only a unit, or what stands in brackets, is of the first one's name.
  const std::size_t open = name.find_first_of("([");
  const bool whole = end != std::string::npos || open != std::string::npos;
  if (open != std::string::npos) name = name.substr(open + 1, name.find_first_of(")]", open) - open - 1);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '_' || c == ':' || c == '/' || c == '"'; }, ' ');
  std::istringstream words(name);
  for (std::string word; words >> word;) {
    if (kUm.contains(word)) return 1;
    if (kNm.contains(word)) return 1e-3;
    if (!whole || kNone.contains(word)) continue;
    unknown = trimmed(name);
    return 0;
  }
  return 1e-3;
}

std::optional<SpectrometerFile> asd_text(const TextFile& text, Problems& problems) {
  for (const char* other : {"radiance", "transmittance", "irradiance", "raw dn", "absorbance"})
    if (text.has(other, 40)) {
      problems.add({text.file, 0, 0, ""}, "an ASD text that is not of reflectance", other,
                   "export reflectance, or write a CSV");
      return std::nullopt;
    }
  const auto names = asd_names_line(text);
  std::string unknown;
  const double unit_um = names ? asd_unit_um(text.lines[*names], unknown) : 1e-3;
  if (!unknown.empty()) {
    problems.add({text.file, static_cast<int>(*names) + 1, 0, ""}, "unknown unit of wavelengths", "'" + unknown + "'",
                 "give nanometres or micrometres");
    return std::nullopt;
  }
  std::size_t first = names.value_or(0) + 1;
  while (!names && first < text.lines.size() && numbers_of(text.lines[first]).size() < 2) ++first;
  SpectrometerFile out = columns(text, first, 1, unit_um, 2);
  for (std::size_t i = 1; i < text.lines.size(); ++i)
    if (numbers_of(text.lines[i]).size() > 2) {
      problems.add({text.file, static_cast<int>(i) + 1, 0, ""}, "an ASD text of several samples",
                   base::counted(numbers_of(text.lines[i]).size(), "column"), "export one sample, or write a CSV");
      return std::nullopt;
    }
  out.kind = "ASD text";
  constexpr std::size_t kWord = 10;  // "wavelength"
  for (const std::string& line : text.lines)
    if (lower_case(line).starts_with("wavelength") && line.size() > kWord) {
      out.name = trimmed(line.substr(kWord + 1));
      if (says_percent(line)) out.scale = 0.01;
    }
  return out;
}

/// A number of a little-endian file.
template <class T>
T at(const std::string& raw, std::size_t place) {
  T value{};
  std::memcpy(&value, raw.data() + place, sizeof value);
  if constexpr (std::endian::native == std::endian::big) {
    auto* bytes = reinterpret_cast<unsigned char*>(&value);
    std::reverse(bytes, bytes + sizeof value);
  }
  return value;
}

/// ASD's Indico format, versions 6 to 8 (ASD document 600502): a header of 484 bytes; the target's values; 2 bytes of
/// flag, 16 of times, a text with its length, and the reference's values.
std::optional<SpectrometerFile> asd_binary(const std::string& file, const std::string& raw, Problems& problems) {
  constexpr std::size_t kHeader = 484, kType = 186, kFirst = 191, kStep = 195, kFormat = 199, kChannels = 204;
  const auto broken = [&](const std::string& what, const std::string& found) {
    problems.add({file, 0, 0, ""}, what, found, "export it as text (ASD ViewSpec Pro), or write a CSV");
    return std::nullopt;
  };
  if (raw.size() < kHeader) return broken("an ASD file ends in its header", base::counted(raw.size(), "byte"));
  const int version = raw[2] - '0', format = raw[kFormat], type = raw[kType];
  if (version < 6 || version > 8) return broken("an ASD file of a version that is not read", raw.substr(0, 3));
  const std::size_t channels = at<std::uint16_t>(raw, kChannels), width = format == 2 ? 8 : 4;
  if (format != 0 && format != 2) return broken("an ASD file of numbers that are not read", std::to_string(format));
  const auto values = [&](std::size_t from, std::vector<double>& to) {
    if (raw.size() < from + channels * width) return false;
    for (std::size_t i = 0; i < channels; ++i)
      to.push_back(format == 2 ? at<double>(raw, from + 8 * i) : static_cast<double>(at<float>(raw, from + 4 * i)));
    return true;
  };
  SpectrometerFile out;
  std::vector<double> reference;
  if (!values(kHeader, out.value)) return broken("an ASD file ends in its values", base::counted(raw.size(), "byte"));
  // Raw or reflectance: either way what the target sent, and after it what the white reference did.
  constexpr int kRaw = 0, kReflectance = 1;
  if (type != kRaw && type != kReflectance)
    return broken("an ASD file that holds no reflectance", "data of type " + std::to_string(type));
  const std::size_t after = kHeader + channels * width;
  const bool told = raw.size() >= after + 20 && at<std::uint16_t>(raw, after) != 0;  // that there is one
  const std::size_t text = told ? at<std::uint16_t>(raw, after + 18) : 0;
  const bool has_reference = told && values(after + 20 + text, reference);
  if (!has_reference && (type == kRaw || told))
    return broken("an ASD file without its white reference", base::counted(raw.size(), "byte"));
  for (std::size_t i = 0; has_reference && i < channels; ++i) out.value[i] /= reference[i];
  for (std::size_t i = 0; i < channels; ++i)
    out.wavelength_um.push_back(1e-3 * (static_cast<double>(at<float>(raw, kFirst)) +
                                        static_cast<double>(i) * static_cast<double>(at<float>(raw, kStep))));
  out.line.assign(channels, 0);
  out.kind = "ASD", out.name = std::filesystem::path(file).filename().string();
  return out;
}

bool is_asd(const std::string& raw) {
  return raw.size() > 3 && (raw.starts_with("ASD") || (raw.starts_with("as") && raw[2] >= '2' && raw[2] <= '9')) &&
         raw.substr(0, std::min<std::size_t>(raw.size(), 484)).find('\0') != std::string::npos;
}

}  // namespace

std::optional<SpectrometerFile> read_spectrometer_file(const std::string& file, const std::string& wavelengths,
                                                       const Where& asked_by, bool& known, Problems& problems) {
  known = false;
  const auto raw = read_whole_file(file, asked_by, problems);
  if (!raw) {
    known = true;
    return std::nullopt;
  }
  known = true;
  if (is_asd(*raw)) return asd_binary(file, *raw, problems);
  const TextFile text = lines_of(file, *raw);
  if (text.is_csv()) {
    known = false;
    return std::nullopt;
  }
  if (text.has("usgs digital spectral library", 3)) return splib06(text);
  if (text.has("splib07", 1)) return splib07(text, wavelengths, asked_by, problems);
  if (text.has("spectra vista", 3)) return sig(text, problems);
  if (!text.value("y units").empty()) return ecostress(text, problems);
  if (text.has("asd spectrum file", 20) ||
      (!text.lines.empty() && lower_case(text.lines[0]).starts_with("wavelength") &&
       text.lines[0].find_first_of(";\t") != std::string::npos))
    return asd_text(text, problems);
  known = false;
  return std::nullopt;
}

}  // namespace raycube::scene
