#include "host/base/gdal_band.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "host/base/gdal_library.h"

namespace raycube::base {
namespace {

bool is_alpha(GDALRasterBandH band) { return gdal().GDALGetRasterColorInterpretation(band) == GCI_AlphaBand; }

/// Bytes from -128 to 127, which have a type of their own from GDAL 3.7 on.
bool has_signed_bytes(GDALRasterBandH band) {
  const char* const type = gdal().GDALGetMetadataItem(band, "PIXELTYPE", "IMAGE_STRUCTURE");
  return gdal().GDALGetRasterDataType(band) == GDT_Byte && type && std::string(type) == "SIGNEDBYTE";
}

/// Largest number that the band's integers can hold, by its type or the bits that the file uses of it.
double most_of(GDALRasterBandH band) {
  double most = 0;
  if (has_signed_bytes(band)) return 127;
  switch (gdal().GDALGetRasterDataType(band)) {
    case GDT_Byte:
      most = 255;
      break;
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 7, 0)
    case GDT_Int8:
      most = 127;
      break;
#endif
    case GDT_UInt16:
      most = 65535;
      break;
    case GDT_Int16:
      most = 32767;
      break;
    case GDT_UInt32:
      most = 4294967295.0;
      break;
    case GDT_Int32:
      most = 2147483647.0;
      break;
    default:
      return 0;
  }
  const char* const bits = gdal().GDALGetMetadataItem(band, "NBITS", "IMAGE_STRUCTURE");
  const int used = bits ? std::atoi(bits) : 0;
  return used > 0 && used < 32 ? std::min(most, std::ldexp(1.0, used) - 1) : most;
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// What stands behind a key in the first lines of a text: "UNIT = ft", "Zunits FEET", "multiplier: 0.1"; empty: none.
std::string said_in(const std::filesystem::path& file, const std::string& key) {
  std::ifstream in(file);
  std::string line;
  for (int read = 0; read < 100 && std::getline(in, line); ++read) {
    const std::string start = trimmed(line);
    if (start.size() <= key.size() || !(start[key.size()] == ' ' || start[key.size()] == '\t' ||
                                        start[key.size()] == '=' || start[key.size()] == ':'))
      continue;
    bool same = true;
    for (std::size_t i = 0; i < key.size(); ++i)
      same = same && std::toupper(static_cast<unsigned char>(start[i])) == key[i];
    const auto value = start.find_first_not_of(" \t=:", key.size());
    if (same && value != std::string::npos) return start.substr(value);
  }
  return "";
}

/// What formats declare and GDAL's drivers do not hand on: unit and scale factor of ENVI and of SAGA, the multiplier of
/// GRASS, and the unit of heights in ESRI's old projection files.
void add_what_drivers_leave_out(GDALRasterBandH band, GdalBand& out) {
  const GDALDatasetH dataset = gdal().GDALGetBandDataset(band);
  const GDALDriverH driver = dataset ? gdal().GDALGetDatasetDriver(dataset) : nullptr;
  const std::string name = driver ? gdal().GDALGetDriverShortName(driver) : "";
  const std::filesystem::path file = dataset ? gdal().GDALGetDescription(dataset) : "";
  const auto beside = [&](const char* extension) { return std::filesystem::path(file).replace_extension(extension); };
  const auto multiply = [&](double factor) {
    if (factor > 0) out.scale *= factor, out.offset *= factor;
  };
  std::string unit;
  if (name == "ENVI") {
    const auto said = [&](const char* key) {
      const char* const value = gdal().GDALGetMetadataItem(dataset, key, "ENVI");
      return std::string(value ? value : "");
    };
    unit = said("data_units");
    const double factor = std::atof(said("reflectance_scale_factor").c_str());
    if (factor > 0) out.scale /= factor, out.offset /= factor;
  } else if (name == "SAGA") {
    unit = said_in(beside(".sgrd"), "UNIT");
    multiply(std::atof(said_in(beside(".sgrd"), "Z_FACTOR").c_str()));
  } else if (name == "GRASSASCIIGrid") {
    multiply(std::atof(said_in(file, "MULTIPLIER").c_str()));
  } else if (name == "AAIGrid" || name == "EHdr") {
    unit = said_in(beside(".prj"), "ZUNITS");
    for (char& c : unit) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  if (out.unit.empty()) out.unit = unit;
  for (const char* none : {"unspecified", "unknown", "none", "no", "undefined"})
    if (out.unit == none) out.unit.clear();
}

}  // namespace

GdalBand describe_band(GDALRasterBandH band) {
  GdalBand out;
  int known = 0;
  const double scale = gdal().GDALGetRasterScale(band, &known), offset = gdal().GDALGetRasterOffset(band, nullptr);
  out.scale = known && std::isfinite(scale) ? scale : 1;
  out.offset = std::isfinite(offset) ? offset : 0;
  if (const char* unit = gdal().GDALGetRasterUnitType(band)) out.unit = unit;
  add_what_drivers_leave_out(band, out);
  out.most = most_of(band);
  out.signed_bytes = has_signed_bytes(band);
  out.palette = gdal().GDALGetRasterColorTable(band) != nullptr;
  int has_no_data = 0;
  out.no_data = gdal().GDALGetRasterNoDataValue(band, &has_no_data);
  if (has_no_data) out.mask = "nodata";
  const int flags = gdal().GDALGetMaskFlags(band);
  if (flags & GMF_ALPHA) {
    if (!is_alpha(band)) out.mask += has_no_data ? " and alpha" : "alpha";
  } else if (!(flags & (GMF_ALL_VALID | GMF_NODATA))) {
    out.mask = "mask";
  }
  return out;
}

bool read_numbers(GDALRasterBandH band, const GdalBand& described, int first_row, int rows,
                  std::vector<double>& numbers, std::vector<Pixel>& known) {
  const int columns = gdal().GDALGetRasterBandXSize(band);
  const std::size_t count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  numbers.resize(count);
  known.assign(count, Pixel::sound);
  const auto read = [&](GDALRasterBandH from, void* to, GDALDataType type) {
    return gdal().GDALRasterIO(from, GF_Read, 0, first_row, columns, rows, to, columns, rows, type, 0, 0) == CE_None;
  };
  if (!read(band, numbers.data(), GDT_Float64)) return false;
  if (!described.mask.empty()) {
    std::vector<unsigned char> mask(count);
    if (!read(gdal().GDALGetMaskBand(band), mask.data(), GDT_Byte)) return false;
    const bool alpha = described.mask.ends_with("alpha");
    for (std::size_t i = 0; i < count; ++i)
      if (mask[i] == 0) known[i] = alpha ? Pixel::transparent : Pixel::missing;
  }
  if (described.signed_bytes)
    for (double& number : numbers) number -= number > 127 ? 256 : 0;
  // Beside an alpha band GDAL's mask leaves the nodata value out; and it takes one that the band's type cannot hold for
  // another.
  const bool no_data = described.mask.starts_with("nodata");
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(numbers[i]) || (no_data && numbers[i] == described.no_data)) known[i] = Pixel::missing;
  return true;
}

bool read_rows(GDALRasterBandH band, const GdalBand& described, int first_row, int rows, std::vector<double>& values,
               std::vector<Pixel>& known) {
  if (!read_numbers(band, described, first_row, rows, values, known)) return false;
  for (double& value : values) value = described.scale * value + described.offset;
  return true;
}

double metres_of(const std::string& unit) {
  std::string name;
  for (const char c : unit)
    if (std::isalnum(static_cast<unsigned char>(c))) name += static_cast<char>(std::tolower(c));
  // The international foot is 0.3048 m; the foot of the United States' surveys is 1200 / 3937 m (NIST SP 811, B.6).
  static const std::map<std::string, double> kMetres = {{"m", 1},
                                                        {"metre", 1},
                                                        {"metres", 1},
                                                        {"meter", 1},
                                                        {"meters", 1},
                                                        {"dm", 0.1},
                                                        {"decimetre", 0.1},
                                                        {"decimeter", 0.1},
                                                        {"decimetres", 0.1},
                                                        {"decimeters", 0.1},
                                                        {"cm", 0.01},
                                                        {"centimetre", 0.01},
                                                        {"centimeter", 0.01},
                                                        {"centimetres", 0.01},
                                                        {"centimeters", 0.01},
                                                        {"mm", 0.001},
                                                        {"millimetre", 0.001},
                                                        {"millimeter", 0.001},
                                                        {"millimetres", 0.001},
                                                        {"millimeters", 0.001},
                                                        {"km", 1000},
                                                        {"kilometre", 1000},
                                                        {"kilometer", 1000},
                                                        {"kilometres", 1000},
                                                        {"kilometers", 1000},
                                                        {"ft", 0.3048},
                                                        {"foot", 0.3048},
                                                        {"feet", 0.3048},
                                                        {"internationalfoot", 0.3048},
                                                        {"footintl", 0.3048},
                                                        {"usft", 1200.0 / 3937},
                                                        {"ftus", 1200.0 / 3937},
                                                        {"ussurveyfoot", 1200.0 / 3937},
                                                        {"ussurveyfeet", 1200.0 / 3937},
                                                        {"footus", 1200.0 / 3937},
                                                        {"usfoot", 1200.0 / 3937},
                                                        {"surveyfoot", 1200.0 / 3937},
                                                        {"yd", 0.9144},
                                                        {"yard", 0.9144}};
  const auto found = kMetres.find(name);
  return found == kMetres.end() ? 0 : found->second;
}

}  // namespace raycube::base
