#include "scene_compiler/envi_library.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

#include "scene_compiler/csv_file.h"

namespace raycube::scene {
namespace {

namespace fs = std::filesystem;
using base::Problems;
using base::Where;

struct HeaderValue {
  std::string text;
  int line = 0;
};
using Header = std::map<std::string, HeaderValue>;

/// "key = value" lines; a value in braces may span lines.
Header parse_header(const std::string& text) {
  Header header;
  std::istringstream stream(text);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto equals = line.find('=');
    if (equals == std::string::npos) continue;
    HeaderValue value{trimmed(line.substr(equals + 1)), number};
    const std::string key = lower_case(trimmed(line.substr(0, equals)));
    if (value.text.starts_with('{')) {
      while (value.text.find('}') == std::string::npos && std::getline(stream, line)) {
        value.text += "\n" + line;
        ++number;
      }
      value.text = trimmed(value.text.substr(
          1, value.text.find('}') == std::string::npos ? std::string::npos : value.text.find('}') - 1));
    }
    header.emplace(key, std::move(value));
  }
  return header;
}

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream stream(text);
  for (std::string item; std::getline(stream, item, ',');) out.push_back(trimmed(item));
  return out;
}

std::string header_of(const std::string& file) {
  std::error_code ignored;
  for (const fs::path& candidate : {fs::path(file + ".hdr"), fs::path(file).replace_extension(".hdr")})
    if (fs::is_regular_file(candidate, ignored)) return candidate.string();
  return "";
}

template <class T>
double load_as(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<T>(raw));
}

struct DataType {
  std::size_t bytes;
  double (*load)(const char*, bool);
};

std::optional<DataType> data_type(int code) {
  switch (code) {
    case 1:
      return DataType{1, load_as<std::uint8_t>};
    case 2:
      return DataType{2, load_as<std::int16_t>};
    case 3:
      return DataType{4, load_as<std::int32_t>};
    case 4:
      return DataType{4, load_as<float>};
    case 5:
      return DataType{8, load_as<double>};
    case 12:
      return DataType{2, load_as<std::uint16_t>};
    case 13:
      return DataType{4, load_as<std::uint32_t>};
    case 14:
      return DataType{8, load_as<std::int64_t>};
    case 15:
      return DataType{8, load_as<std::uint64_t>};
    default:
      return std::nullopt;
  }
}

class HeaderReader {
 public:
  HeaderReader(std::string file, Header header, Problems& problems)
      : file_(std::move(file)), header_(std::move(header)), problems_(problems) {}

  Where at(const std::string& key) const {
    const auto found = header_.find(key);
    return {file_, found == header_.end() ? 0 : found->second.line, 0, ""};
  }
  const HeaderValue* find(const std::string& key) const {
    const auto found = header_.find(key);
    return found == header_.end() ? nullptr : &found->second;
  }
  /// A non-negative integer; fallback < 0: required.
  std::int64_t integer(const std::string& key, std::int64_t fallback) {
    const HeaderValue* value = find(key);
    if (value == nullptr) {
      if (fallback < 0)
        problems_.add({file_, 0, 0, ""}, "ENVI header lacks '" + key + "'", "", "add " + key + " = ...");
      return std::max<std::int64_t>(fallback, 0);
    }
    const auto number = parse_number(value->text);
    if (!number || *number < 0 || *number > 1e15 ||
        *number != static_cast<double>(static_cast<std::int64_t>(*number))) {
      problems_.add(at(key), "'" + key + "' is not a whole number", value->text, "give an integer from 0");
      return 0;
    }
    return static_cast<std::int64_t>(*number);
  }

 private:
  std::string file_;
  Header header_;
  Problems& problems_;
};

std::vector<double> read_wavelengths(HeaderReader& header, std::size_t count, Problems& problems) {
  const HeaderValue* list = header.find("wavelength");
  const HeaderValue* units = header.find("wavelength units");
  if (list == nullptr || units == nullptr) {
    problems.add(header.at("samples"),
                 std::string("ENVI header lacks '") + (list == nullptr ? "wavelength" : "wavelength units") + "'", "",
                 "add it; units are Micrometers or Nanometers");
    return {};
  }
  const std::string unit = lower_case(units->text);
  double um = 0;
  if (unit == "micrometers" || unit == "um" || unit == "microns") um = 1;
  if (unit == "nanometers" || unit == "nm") um = 1e-3;
  if (um == 0)
    problems.add(header.at("wavelength units"), "unknown wavelength unit", units->text,
                 "write Micrometers or Nanometers");
  std::vector<double> out;
  const auto items = split_list(list->text);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto number = parse_number(items[i]);
    Where where = header.at("wavelength");
    where.element = "wavelength " + std::to_string(i + 1);
    if (number)
      out.push_back(*number * um);
    else
      problems.add(where, "not a number", "'" + items[i] + "'", "correct the list");
  }
  if (items.size() != count)
    problems.add(header.at("wavelength"), "number of wavelengths differs from 'samples'",
                 std::to_string(items.size()) + " wavelengths, " + std::to_string(count) + " samples",
                 "correct the header");
  return out;
}

}  // namespace

std::optional<EnviLibrary> read_envi_library(const std::string& file, const Where& asked_by, Problems& problems) {
  const std::string header_file = header_of(file);
  if (header_file.empty()) {
    problems.add(asked_by, "spectral library has no header", file,
                 "put " + fs::path(file).filename().string() + ".hdr beside it");
    return std::nullopt;
  }
  const auto header_text = read_whole_file(header_file, asked_by, problems);
  const auto data = read_whole_file(file, asked_by, problems);
  if (!header_text || !data) return std::nullopt;
  if (!header_text->starts_with("ENVI")) {
    problems.add({header_file, 1, 0, ""}, "not an ENVI header", header_text->substr(0, 20), "its first line is ENVI");
    return std::nullopt;
  }
  const std::size_t before = problems.count();
  HeaderReader header(header_file, parse_header(*header_text), problems);
  const auto samples = static_cast<std::size_t>(header.integer("samples", -1));
  const auto lines = static_cast<std::size_t>(header.integer("lines", -1));
  const auto offset = static_cast<std::size_t>(header.integer("header offset", 0));
  const auto order = header.integer("byte order", 0);
  const int code = static_cast<int>(header.integer("data type", -1));
  const auto type = data_type(code);
  if (!type)
    problems.add(header.at("data type"), "ENVI data type is not a real number's", std::to_string(code),
                 "convert to 4 or 5");
  if (order > 1)
    problems.add(header.at("byte order"), "byte order is 0 or 1", std::to_string(order), "0 little, 1 big endian");
  if (problems.count() != before) return std::nullopt;
  // Sizes come from a text file: compare by division so that no product can overflow.
  if (samples == 0 || lines == 0 || offset > data->size() || lines > (data->size() - offset) / type->bytes / samples) {
    problems.add({file, 0, 0, ""}, "data file is shorter than its header says",
                 std::to_string(data->size()) + " bytes for " + std::to_string(lines) + " spectra of " +
                     std::to_string(samples) + " samples",
                 "restore the file or correct " + header_file);
    return std::nullopt;
  }
  EnviLibrary library;
  library.header_file = header_file;
  library.wavelength_um = read_wavelengths(header, samples, problems);
  if (const auto* names = header.find("spectra names")) library.names = split_list(names->text);
  if (library.names.size() != lines)
    problems.add(header.at("spectra names"), "number of 'spectra names' differs from 'lines'",
                 std::to_string(library.names.size()) + " names, " + std::to_string(lines) + " lines",
                 "name every spectrum");
  if (const auto* factor = header.find("reflectance scale factor")) {
    const auto number = parse_number(factor->text);
    if (number && *number > 0)
      library.scale_factor = *number;
    else
      problems.add(header.at("reflectance scale factor"), "not a positive number", factor->text, "give a number > 0");
  }
  if (problems.count() != before) return std::nullopt;
  const bool swap = (order == 1) != (std::endian::native == std::endian::big);
  for (std::size_t line = 0; line < lines; ++line) {
    auto& spectrum = library.spectra.emplace_back(samples);
    for (std::size_t i = 0; i < samples; ++i)
      spectrum[i] = type->load(data->data() + offset + (line * samples + i) * type->bytes, swap);
  }
  return library;
}

}  // namespace raycube::scene
