#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/memory.h"
#include "host/base/text.h"
#include "host/products/envi_header.h"

namespace raycube::products {
namespace {

using base::Error;
using base::Fault;
using base::Problems;
using base::Where;

constexpr std::uintmax_t kLargestHeader_bytes = 64u << 20;
constexpr std::int64_t kLargestDimension = std::int64_t{1} << 31;

std::string trim(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// Keys compare in lower case with single spaces.
std::string canonical_key(const std::string& text) {
  std::istringstream words(base::lower_case(text));
  std::string out;
  for (std::string word; words >> word;) out += (out.empty() ? "" : " ") + word;
  return out;
}

/// One `key = value`; a braced value has lost its outer braces.
struct Entry {
  std::string value;
  int line = 0;
  bool braced = false;
};

/// One whole number or real; the whole text must be it.
template <class Number>
bool parse_number(const std::string& text, Number& value) {
  std::string word = trim(text);
  if (!word.empty() && word[0] == '+') word.erase(0, 1);
  const auto [rest, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && code == std::errc() && rest == word.data() + word.size();
}

class Parser {
 public:
  Parser(const std::string& text, const std::string& file) : file_(file) { split(text); }

  EnviHeader parse() {
    EnviHeader h;
    dimension("samples", h.samples);
    dimension("lines", h.lines);
    text("file type", h.file_type);
    names("spectra names", h.spectra_names);
    settle_kind(h);
    if (!h.spectral_library || entries_.contains("bands")) dimension("bands", h.bands);
    if (const auto* entry = take("header offset"))
      if (!parse_number(entry->value, h.header_offset))
        problem("header offset", *entry, "must be a whole number of bytes");
    if (const auto* entry = required("data type"))
      if (!parse_number(entry->value, h.data_type) || !find_envi_type(h.data_type))
        problem("data type", *entry, "must be one of 1, 2, 3, 4, 5, 6, 9, 12, 13, 14, 15");
    if (const auto* entry = h.spectral_library && h.bands == 1 ? take("interleave") : required("interleave")) {
      const std::string name = base::lower_case(trim(entry->value));
      if (name == "bsq" || name == "bil" || name == "bip")
        h.interleave = parse_interleave(name);
      else
        problem("interleave", *entry, "must be bip, bil or bsq");
    }
    if (const auto* entry = take("byte order"))
      if (!parse_number(entry->value, h.byte_order) || (h.byte_order != 0 && h.byte_order != 1))
        problem("byte order", *entry, "must be 0 (little endian) or 1 (big endian)");
    refuse_unless_plain();
    text("description", h.description);
    text("sensor type", h.sensor_type);
    text("data units", h.data_units);
    text("acquisition time", h.acquisition_time);
    text("wavelength units", h.wavelength_units);
    text("coordinate system string", h.coordinate_system);
    real("sun azimuth", h.sun_azimuth_deg);
    real("sun elevation", h.sun_elevation_deg);
    real("data ignore value", h.data_ignore_value);
    real("reflectance scale factor", h.reflectance_scale_factor);
    names("map info", h.map_info);
    names("band names", h.band_names);
    numbers("wavelength", h.wavelength);
    numbers("fwhm", h.fwhm);
    numbers("data gain values", h.data_gain);
    numbers("data offset values", h.data_offset);
    whole_numbers("bbl", 1, h.bad_bands);
    whole_numbers("default bands", std::numeric_limits<int>::max(), h.default_bands);
    check_dimensions(h);
    problems_.throw_if_any();
    check_lengths(h);
    for (const auto& [key, entry] : entries_) h.other[key] = entry.braced ? "{" + entry.value + "}" : entry.value;
    h.warnings = warnings_;
    return h;
  }

 private:
  void split(const std::string& text) {
    std::istringstream in(text);
    std::string line;
    std::getline(in, line);
    if (line.rfind("\xef\xbb\xbf", 0) == 0) line.erase(0, 3);
    if (trim(line) != "ENVI") {
      problems_.add({file_, 1, 0, ""}, "is not an ENVI header: its first line must be ENVI",
                    text.empty() ? "an empty file" : "\"" + trim(line).substr(0, 40) + "\"",
                    "name the .hdr file or its data file");
      problems_.throw_if_any();
    }
    for (int number = 2; std::getline(in, line); ++number) {
      const std::string bare = trim(line);
      if (bare.empty() || bare[0] == ';') continue;
      const auto equals = bare.find('=');
      if (equals == std::string::npos) {
        warnings_.push_back(fmt::format("{}:{}: a line without \"=\" is ignored", file_, number));
        continue;
      }
      const std::string key = canonical_key(bare.substr(0, equals));
      Entry entry{trim(bare.substr(equals + 1)), number, false};
      if (!entry.value.empty() && entry.value[0] == '{') read_braces(in, key, entry, number);
      const auto [old, is_new] = entries_.try_emplace(key, entry);
      if (!is_new && old->second.value != entry.value)
        problems_.add({file_, entry.line, 0, ""},
                      fmt::format("\"{}\" stands twice, first in line {}", key, old->second.line),
                      entry.value.substr(0, 40), "keep one of the two");
    }
  }

  /// Appends lines until the braces are balanced.
  void read_braces(std::istream& in, const std::string& key, Entry& entry, int& number) {
    const auto depth = [](const std::string& text) {
      return std::count(text.begin(), text.end(), '{') - std::count(text.begin(), text.end(), '}');
    };
    auto open = depth(entry.value);
    for (std::string line; open > 0 && std::getline(in, line); ++number) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      entry.value += "\n" + line;
      open += depth(line);
    }
    entry.braced = true;
    const auto close = entry.value.rfind('}');
    if (open > 0 || close == std::string::npos) {
      problems_.add({file_, entry.line, 0, ""}, fmt::format("the brace of \"{}\" is never closed", key), "",
                    "add the missing }");
      problems_.throw_if_any();  // everything after it has been swallowed
    }
    entry.value = trim(entry.value.substr(1, close - 1));
  }

  const Entry* take(const std::string& key) {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return nullptr;
    taken_ = found->second;
    entries_.erase(found);
    return &taken_;
  }

  const Entry* required(const std::string& key) {
    const Entry* entry = take(key);
    if (!entry)
      problems_.add({file_, 0, 0, ""}, "the key \"" + key + "\" is missing", "", "add it: ENVI cannot be read without");
    return entry;
  }

  void problem(const std::string& key, const Entry& entry, const std::string& rule) {
    problems_.add({file_, entry.line, 0, ""}, "\"" + key + "\" " + rule, entry.value.substr(0, 40),
                  "correct the header");
  }

  void dimension(const std::string& key, std::int64_t& value) {
    const Entry* entry = required(key);
    if (entry && (!parse_number(entry->value, value) || value < 1 || value > kLargestDimension))
      problem(key, *entry, fmt::format("must be a whole number from 1 to {}", kLargestDimension));
  }

  /// A spectral library says so, or has one band and a name for each of its lines. Libraries are one band, which some
  /// headers leave to be known.
  void settle_kind(EnviHeader& h) {
    const auto bands = entries_.find("bands");
    std::int64_t count = 1;
    const bool one = bands == entries_.end() || (parse_number(bands->second.value, count) && count == 1);
    const bool named = !h.spectra_names.empty() && h.spectra_names.size() == static_cast<std::size_t>(h.lines);
    h.spectral_library = canonical_key(h.file_type) == "envi spectral library" || (one && named);
    if (h.spectral_library) h.bands = 1;
  }

  /// What changes where numbers lie, which is not read.
  void refuse_unless_plain() {
    for (const char* key : {"file compression", "major frame offsets", "minor frame offsets"}) {
      std::vector<double> values;
      const auto entry = entries_.find(key);
      if (entry == entries_.end()) continue;
      const Entry declared = entry->second;
      numbers(key, values);
      if (std::any_of(values.begin(), values.end(), [](double value) { return value != 0; }))
        problem(key, declared, "is not read but as 0");
    }
  }

  void text(const std::string& key, std::string& value) {
    if (const auto* entry = take(key)) value = entry->value;
  }

  void real(const std::string& key, std::optional<double>& value) {
    const Entry* entry = take(key);
    if (!entry) return;
    double parsed = 0;
    if (parse_number(entry->value, parsed))
      value = parsed;
    else
      problem(key, *entry, "must be a number");
  }

  void names(const std::string& key, std::vector<std::string>& values) {
    const Entry* entry = take(key);
    if (!entry) return;
    std::istringstream in(entry->value);
    for (std::string item; std::getline(in, item, ',');) values.push_back(trim(item));
    while (!values.empty() && values.back().empty()) values.pop_back();
  }

  void numbers(const std::string& key, std::vector<double>& values) {
    const Entry* entry = take(key);
    if (!entry) return;
    std::istringstream in(entry->value);
    int index = 0;
    for (std::string item; std::getline(in, item, ','); ++index) {
      if (trim(item).empty() && in.eof()) break;  // a comma before the closing brace
      double value = 0;
      if (!parse_number(item, value)) {
        problems_.add({file_, entry->line, 0, ""}, fmt::format("value {} of \"{}\" must be a number", index + 1, key),
                      "\"" + trim(item).substr(0, 40) + "\"", "correct the header");
        return;
      }
      values.push_back(value);
    }
  }

  /// Whole numbers from 0 to `most`, however they are written: "3", "3.0".
  void whole_numbers(const std::string& key, int most, std::vector<int>& values) {
    const auto entry = entries_.find(key);
    const int line = entry == entries_.end() ? 0 : entry->second.line;
    std::vector<double> reals;
    numbers(key, reals);
    for (const double value : reals) {
      if (!(value >= 0 && value <= most) || value != std::floor(value)) {
        problems_.add({file_, line, 0, ""}, fmt::format("\"{}\" must be whole numbers from 0 to {}", key, most),
                      fmt::format("{:g}", value), "correct the header");
        return;
      }
      values.push_back(static_cast<int>(value));
    }
  }

  void check_dimensions(const EnviHeader& h) {
    if (h.samples < 1 || h.lines < 1 || h.bands < 1 || !find_envi_type(h.data_type)) return;
    const long double bytes =
        static_cast<long double>(h.samples) * h.lines * h.bands * h.type().bytes + h.header_offset;
    if (bytes > 0x1p62L)
      problems_.add({file_, 0, 0, ""}, "the image would have more than 2^62 bytes",
                    fmt::format("{} samples x {} lines x {} bands", h.samples, h.lines, h.bands), "correct the header");
  }

  template <class List>
  void check_length(const char* key, List& list, std::size_t wanted) {
    if (list.empty() || list.size() == wanted) return;
    warnings_.push_back(fmt::format("{}: \"{}\" has {}, not {}; it is ignored", file_, key,
                                    base::counted(list.size(), "value"), wanted));
    list.clear();
  }

  void check_lengths(EnviHeader& h) {
    const auto bands = static_cast<std::size_t>(h.bands);
    const std::size_t spectral = h.spectral_library ? static_cast<std::size_t>(h.samples) : bands;
    check_length("wavelength", h.wavelength, spectral);
    check_length("fwhm", h.fwhm, spectral);
    check_length("bbl", h.bad_bands, spectral);
    check_length("band names", h.band_names, bands);
    // A library has one of these, or one for each sample.
    check_length("data gain values", h.data_gain, h.spectral_library && h.data_gain.size() == 1 ? 1 : spectral);
    check_length("data offset values", h.data_offset, h.spectral_library && h.data_offset.size() == 1 ? 1 : spectral);
    check_spectral("wavelength", h.wavelength, h.wavelength_um());
    check_spectral("fwhm", h.fwhm, h.fwhm_um());
    if (!h.wavelength.empty() && h.wavelength_um().empty())
      warnings_.push_back(fmt::format("{}: {}; they are not used", file_, h.why_no_wavelengths()));
    if (h.spectral_library) {
      check_length("spectra names", h.spectra_names, static_cast<std::size_t>(h.lines));
    } else if (!h.spectra_names.empty()) {
      warnings_.push_back(file_ + ": \"spectra names\" is ignored: the file is an image, no spectral library");
      h.spectra_names.clear();
    }
    for (const int band : h.default_bands)
      if (band < 1 || band > h.bands) {
        warnings_.push_back(
            fmt::format("{}: \"default bands\" names band {} of {}; it is ignored", file_, band, h.bands));
        h.default_bands.clear();
        break;
      }
  }

  /// No wavelength or width is negative or infinite: of wavenumbers, what a width of twice their centre becomes.
  void check_spectral(const char* key, std::vector<double>& list, const std::vector<double>& um) {
    const auto sound = [](double v) { return v >= 0 && std::isfinite(v); };
    for (std::size_t i = 0; i < um.size(); ++i) {
      if (sound(um[i]) && sound(list[i])) continue;
      warnings_.push_back(fmt::format("{}: value {} of \"{}\", {:g}, is {:g} um in wavelengths; the key is ignored",
                                      file_, i + 1, key, list[i], um[i]));
      list.clear();
      return;
    }
  }

  std::string file_;
  std::map<std::string, Entry> entries_;
  Entry taken_;
  Problems problems_;
  std::vector<std::string> warnings_;
};

}  // namespace

EnviHeader parse_envi_header(const std::string& text, const std::string& file) { return Parser(text, file).parse(); }

EnviHeader read_envi_header(const std::string& path) {
  base::refuse_other_than_plain(path);
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw Error(Fault::input, path + ": cannot be opened; check the name and the permissions");
  const auto bytes = static_cast<std::uintmax_t>(std::max<std::streamoff>(in.tellg(), 0));
  if (bytes > kLargestHeader_bytes)
    throw Error(Fault::input, fmt::format("{}: is too large for a header (found {}); is it the data file?", path,
                                          base::format_bytes(bytes)));
  std::string text(bytes, '\0');
  in.seekg(0).read(text.data(), static_cast<std::streamsize>(bytes));
  if (!in) throw Error(Fault::environment, path + ": could not be read to its end");
  return parse_envi_header(text, path);
}

}  // namespace raycube::products
