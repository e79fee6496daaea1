#include "host/base/text_grid.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>

#include "host/base/gdal_library.h"
#include "host/base/text.h"

namespace raycube::base {
namespace {

/// The number of a word, infinite where it is larger than any.
std::optional<double> number_in(std::string word) {
  std::replace(word.begin(), word.end(), ',', '.');  // decimal commas, which GDAL takes
  const char* const from = word.data() + (word.size() > 1 && word[0] == '+');
  double value = 0;
  const auto [end, error] = std::from_chars(from, word.data() + word.size(), value);
  if (end != word.data() + word.size() || (error != std::errc() && error != std::errc::result_out_of_range))
    return std::nullopt;
  return error == std::errc() ? value : std::numeric_limits<double>::infinity();
}

/// Whether GDAL, which reads a word by the type of the band, has its number: of integers digits alone.
bool holds(GDALDataType type, const std::string& word, double value) {
  if (type == GDT_Int32)
    return std::abs(value) <= 2147483647 && word.find_first_not_of("+-0123456789") == std::string::npos;
  return type != GDT_Float32 || std::isnan(value) || std::abs(value) <= std::numeric_limits<float>::max();
}

/// Leaves a text grid at its first number: behind keys and their values, or behind Surfer's head of nine words.
void pass_head(std::istream& in, const std::string& driver) {
  std::string word;
  if (driver == "GSAG") {
    for (int i = 0; i < 9; ++i) in >> word;
    return;
  }
  while (in >> std::ws && !in.eof() && !std::isdigit(in.peek()) && in.peek() != '-' && in.peek() != '+' &&
         in.peek() != '.') {
    const auto at = in.tellg();
    in >> word;
    const std::string key = lower_case(word);
    const bool known = key == "ncols" || key == "nrows" || key == "cellsize" || key == "dx" || key == "dy" ||
                       key == "nodata_value" || key.starts_with("xll") || key.starts_with("yll") || key.ends_with(":");
    if (!known) {
      in.seekg(at);
      return;
    }
    in >> word;
  }
}

}  // namespace

TextGrid read_text_grid(GDALDatasetH dataset, const std::string& file) {
  TextGrid out;
  const std::string driver = gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(dataset));
  if (driver != "AAIGrid" && driver != "GRASSASCIIGrid" && driver != "GSAG") return out;
  std::ifstream in(file);
  pass_head(in, driver);
  const auto columns = static_cast<std::int64_t>(gdal().GDALGetRasterXSize(dataset)),
             needed = columns * gdal().GDALGetRasterYSize(dataset);
  const GDALDataType type = gdal().GDALGetRasterDataType(gdal().GDALGetRasterBand(dataset, 1));
  std::int64_t count = 0;
  const auto told = [&](const std::string& word, const char* what) {
    return "'" + word.substr(0, 40) + "' " + what + " (row " + std::to_string(count / columns) + ", column " +
           std::to_string(count % columns) + ", counted from 0)";
  };
  for (std::string word; in >> word; ++count) {
    const auto value = number_in(word);
    if (!value) {
      out.wrong = told(word, "is no number");
      return out;
    }
    // GDAL takes the first number for a key of the header where it begins with a letter, and its row with it.
    if (count == 0 && driver != "GSAG" && std::isalpha(static_cast<unsigned char>(word[0]))) {
      out.wrong = told(word, "is taken by GDAL for a word of the header, where a grid begins with it") +
                  "; write -nan there, or declare a NODATA_value and write that";
      return out;
    }
    if (out.beyond.empty() && !holds(type, word, *value)) out.beyond = told(word, "is read as another number");
  }
  if (count != needed)
    out.wrong = "it holds " + base::counted(count, "number") + ", its header counts " + std::to_string(needed);
  return out;
}

}  // namespace raycube::base
