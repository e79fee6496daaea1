#include "host/base/gdal_open.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

namespace raycube::base {
namespace {

/// Of a raw file that ends before its header says: what is wrong; else empty. GDAL reads what is missing as zeros (with
/// RAW_CHECK_FILE_SIZE it refuses files of less than half their size alone).
std::string cut_short(GDALDatasetH dataset, const std::string& file) {
  const std::string driver = gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(dataset));
  if (driver != "ENVI" && driver != "EHdr" && driver != "ISCE" && driver != "ROI_PAC") return "";
  const auto said = [&](const char* key, const char* domain) {
    const char* const value = gdal().GDALGetMetadataItem(dataset, key, domain);
    return value ? std::atof(value) : 0.0;
  };
  if (said("file_compression", "ENVI") != 0) return "";
  double bits = 0;
  for (int b = 1; b <= gdal().GDALGetRasterCount(dataset); ++b) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(dataset, b);
    const char* const fewer = gdal().GDALGetMetadataItem(band, "NBITS", "IMAGE_STRUCTURE");
    bits += fewer ? std::atof(fewer) : gdal().GDALGetDataTypeSizeBits(gdal().GDALGetRasterDataType(band));
  }
  const double needed = std::ceil(bits * gdal().GDALGetRasterXSize(dataset) * gdal().GDALGetRasterYSize(dataset) / 8) +
                        said("header_offset", "ENVI");
  std::error_code failed;
  const auto bytes = static_cast<double>(std::filesystem::file_size(file, failed));
  if (failed || bytes >= needed) return "";
  return "the file ends after " + std::to_string(static_cast<std::uint64_t>(bytes)) + " of " +
         std::to_string(static_cast<std::uint64_t>(needed)) + " bytes";
}

bool is_number(std::string word) {
  std::replace(word.begin(), word.end(), ',', '.');  // decimal commas, which GDAL takes
  const char* const from = word.data() + (word.size() > 1 && word[0] == '+');
  double value = 0;
  const auto [end, error] = std::from_chars(from, word.data() + word.size(), value);
  return (error == std::errc() || error == std::errc::result_out_of_range) && end == word.data() + word.size();
}

/// Of an ESRI text grid whose words are not the numbers that its header counts: what is wrong; else empty. GDAL reads
/// words as 0, and goes on with the next number where one is missing.
std::string miscounted_grid(GDALDatasetH dataset, const std::string& file) {
  if (std::string(gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(dataset))) != "AAIGrid") return "";
  std::ifstream in(file);
  std::string word, value;
  // Keys and their values, until a line begins with a number.
  while (in >> std::ws && !in.eof() && !std::isdigit(in.peek()) && in.peek() != '-' && in.peek() != '+' &&
         in.peek() != '.') {
    const auto at = in.tellg();
    in >> word;
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    const bool key = word == "ncols" || word == "nrows" || word == "cellsize" || word == "dx" || word == "dy" ||
                     word == "nodata_value" || word.starts_with("xll") || word.starts_with("yll");
    if (!key) {
      in.seekg(at);
      break;
    }
    in >> value;
  }
  const double needed = double(gdal().GDALGetRasterXSize(dataset)) * gdal().GDALGetRasterYSize(dataset);
  double count = 0;
  for (; in >> word; ++count)
    if (!is_number(word)) {
      const auto columns = static_cast<double>(gdal().GDALGetRasterXSize(dataset));
      return "'" + word.substr(0, 40) + "' is no number (row " +
             std::to_string(static_cast<std::int64_t>(count / columns) + 1) + ", column " +
             std::to_string(static_cast<std::int64_t>(std::fmod(count, columns)) + 1) + ")";
    }
  if (count == needed) return "";
  return "it holds " + std::to_string(static_cast<std::int64_t>(count)) + " numbers, its header counts " +
         std::to_string(static_cast<std::int64_t>(needed));
}

}  // namespace

OpenedByGdal open_by_gdal(const std::string& file, unsigned kinds) {
  const QuietGdal quiet;
  OpenedByGdal out{GdalDataset(gdal().GDALOpenEx(file.c_str(), kinds | GDAL_OF_READONLY, nullptr, nullptr, nullptr)),
                   ""};
  if (!out.set) {
    out.wrong = gdal_message();
    if (out.wrong.empty()) out.wrong = "no message";
    return out;
  }
  if (gdal().GDALGetRasterCount(out.set.get()) == 0) return out;
  out.wrong = cut_short(out.set.get(), file);
  if (out.wrong.empty()) out.wrong = miscounted_grid(out.set.get(), file);
  if (!out.wrong.empty()) out.set.reset();
  return out;
}

}  // namespace raycube::base
