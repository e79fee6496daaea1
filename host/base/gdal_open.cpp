#include "host/base/gdal_open.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/base/gdal_band.h"
#include "host/base/input_file.h"
#include "host/base/netcdf_size.h"

namespace raycube::base {
namespace {

/// open_by_gdal(), of a source in a virtual raster in a virtual raster ...
OpenedByGdal open_at_depth(const std::string& file, unsigned kinds, int depth);

/// Of a raw file that ends before its header says: what is wrong; else empty. GDAL reads what is missing as zeros (with
/// RAW_CHECK_FILE_SIZE it refuses files of less than half their size alone).
std::string cut_short(GDALDatasetH dataset, const std::string& file) {
  const std::string driver = gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(dataset));
  std::error_code failed;
  const auto bytes = static_cast<double>(std::filesystem::file_size(file, failed));
  const auto ends_early = [&](double needed) {
    return failed || bytes >= needed ? std::string()
                                     : "the file ends after " + std::to_string(static_cast<std::uint64_t>(bytes)) +
                                           " of " + std::to_string(static_cast<std::uint64_t>(needed)) + " bytes";
  };
  if (driver == "netCDF") return ends_early(static_cast<double>(netcdf_bytes(file)));
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
  return ends_early(needed);
}

bool is_number(std::string word) {
  std::replace(word.begin(), word.end(), ',', '.');  // decimal commas, which GDAL takes
  const char* const from = word.data() + (word.size() > 1 && word[0] == '+');
  double value = 0;
  const auto [end, error] = std::from_chars(from, word.data() + word.size(), value);
  return (error == std::errc() || error == std::errc::result_out_of_range) && end == word.data() + word.size();
}

std::string lower(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  return word;
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
    const std::string key = lower(word);
    const bool known = key == "ncols" || key == "nrows" || key == "cellsize" || key == "dx" || key == "dy" ||
                       key == "nodata_value" || key.starts_with("xll") || key.starts_with("yll") || key.ends_with(":");
    if (!known) {
      in.seekg(at);
      return;
    }
    in >> word;
  }
}

/// Of a text grid whose words are not the numbers that its header counts: what is wrong; else empty. GDAL reads words
/// as 0, and goes on with the next number where one is missing.
std::string miscounted_grid(GDALDatasetH dataset, const std::string& file) {
  const std::string driver = gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(dataset));
  if (driver != "AAIGrid" && driver != "GRASSASCIIGrid" && driver != "GSAG") return "";
  std::ifstream in(file);
  pass_head(in, driver);
  const double needed = double(gdal().GDALGetRasterXSize(dataset)) * gdal().GDALGetRasterYSize(dataset);
  double count = 0;
  for (std::string word; in >> word; ++count)
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

/// What any band of a raster declares of its numbers.
struct Declared {
  bool scaled = false, unit = false, gaps = false;
};
Declared declared_by(GDALDatasetH dataset) {
  Declared out;
  for (int b = 1; b <= gdal().GDALGetRasterCount(dataset); ++b) {
    const GdalBand band = describe_band(gdal().GDALGetRasterBand(dataset, b));
    out.scaled = out.scaled || band.scaled();
    out.unit = out.unit || !band.unit.empty();
    out.gaps = out.gaps || !band.mask.empty();
  }
  return out;
}

/// "NAME, which is a pipe", of the files that GDAL looks for beside this one (.prj, .aux.xml, world files, headers):
/// opening a pipe waits for its writer, and a device may never end. Empty: there is none.
std::string special_beside(const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path path(file);
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(path.has_parent_path() ? path.parent_path() : ".", code)) {
    const fs::path name = entry.path().filename();
    if (name.stem() != path.stem() && !name.string().starts_with(path.filename().string() + ".")) continue;
    if (entry.is_regular_file(code) || entry.is_directory(code) || !entry.exists(code)) continue;
    if (name != path.filename()) return entry.path().string() + ", which " + why_no_plain_file(entry.path().string());
  }
  return "";
}

/// The same of the files that a virtual raster takes its values from, and of theirs.
std::string special_source(const std::string& file, int depth = 0) {
  constexpr int kDeepest = 8;
  constexpr std::size_t kMostBytes = 64 << 20;
  namespace fs = std::filesystem;
  if (depth == kDeepest || !why_no_plain_file(file).empty()) return "";
  std::ifstream in(file, std::ios::binary);
  std::string text(1024, '\0');
  in.read(text.data(), 1024);
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.find("<VRTDataset") == std::string::npos) return "";
  for (std::string more(1 << 16, '\0'); text.size() < kMostBytes && in.read(more.data(), 1 << 16).gcount() > 0;)
    text.append(more, 0, static_cast<std::size_t>(in.gcount()));
  for (const char* tag : {"<SourceFilename", "<SourceDataset"})
    for (std::size_t at = text.find(tag); at != std::string::npos; at = text.find(tag, at + 1)) {
      const std::size_t begin = text.find('>', at), end = text.find('<', at + 1);
      if (begin == std::string::npos || end == std::string::npos || end < begin) break;
      const fs::path named = text.substr(begin + 1, end - begin - 1);
      const bool relative = text.substr(at, begin - at).find("relativeToVRT=\"1\"") != std::string::npos;
      const fs::path source = relative ? fs::path(file).parent_path() / named : named;
      std::error_code code;
      if (!fs::exists(source, code) || fs::is_directory(source, code)) continue;
      if (const std::string why = why_no_plain_file(source.string()); !why.empty())
        return source.string() + ", which " + why;
      for (const std::string& inner : {special_beside(source.string()), special_source(source.string(), depth + 1)})
        if (!inner.empty()) return inner;
    }
  return "";
}

/// Looks at the files that a virtual raster is made of: GDAL takes the numbers of each as they stand.
void look_at_sources(OpenedByGdal& opened, const std::string& file, int depth) {
  constexpr int kDeepest = 8;
  if (depth > kDeepest ||
      std::string(gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(opened.set.get()))) != "VRT")
    return;
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  const auto says = [&](const char* key) { return text.str().find(key) != std::string::npos; };
  const Declared here = declared_by(opened.set.get());
  char** const files = gdal().GDALGetFileList(opened.set.get());
  for (char** each = files; each && *each && opened.wrong.empty(); ++each) {
    const std::string source = *each;
    std::error_code failed;
    if (std::filesystem::equivalent(source, file, failed) || source.ends_with(".xml")) continue;
    OpenedByGdal part = open_at_depth(source, GDAL_OF_RASTER, depth + 1);
    if (!part.set && std::filesystem::exists(source, failed) && part.refused) {
      opened.wrong = "its source " + source + ": " + part.wrong;
      break;
    }
    if (!part.set) continue;
    const Declared there = declared_by(part.set.get());
    std::string left;
    const auto leave = [&](bool is, const char* what) {
      if (is) left += (left.empty() ? "" : " and ") + std::string(what);
    };
    leave(there.scaled && !here.scaled && !says("<ScaleRatio>"), "a scale or an offset");
    leave(there.unit && !here.unit, "a unit");
    leave(there.gaps && !here.gaps && !says("<NODATA>") && !says("<UseMaskBand>"), "pixels without data");
    if (!left.empty())
      opened.told.push_back("its source " + source + " declares " + left +
                            ", which the virtual raster leaves out; make it by gdalbuildvrt, or name the source");
    opened.told.insert(opened.told.end(), part.told.begin(), part.told.end());
  }
  gdal().CSLDestroy(files);
}

OpenedByGdal open_at_depth(const std::string& file, unsigned kinds, int depth) {
  const QuietGdal quiet;
  OpenedByGdal out;
  if (depth == 0)  // which looks at sources of sources, too
    for (const std::string& special : {special_beside(file), special_source(file)})
      if (!special.empty()) {
        out.wrong = "it needs " + special, out.refused = true;
        return out;
      }
  out.set = GdalDataset(gdal().GDALOpenEx(file.c_str(), kinds | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  if (!out.set) {
    out.wrong = gdal_message();
    if (out.wrong.empty()) out.wrong = "no message";
    return out;
  }
  if (gdal().GDALGetRasterCount(out.set.get()) == 0) return out;
  out.wrong = cut_short(out.set.get(), file);
  if (out.wrong.empty()) out.wrong = miscounted_grid(out.set.get(), file);
  if (out.wrong.empty()) look_at_sources(out, file, depth);
  if (!out.wrong.empty()) out.set.reset(), out.refused = true;
  return out;
}

}  // namespace

OpenedByGdal open_by_gdal(const std::string& file, unsigned kinds) { return open_at_depth(file, kinds, 0); }

}  // namespace raycube::base
