#include "scene_compiler/raster.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "host/base/gdal_library.h"
#include "host/base/limited_child.h"
#include "scene_compiler/csv_file.h"

namespace raycube::scene {
namespace {

using base::gdal;
using base::GdalDataset;
using base::GdalSpatialReference;
using base::Problems;
using base::QuietGdal;
using base::Where;

// What reading may take: GDAL needs some 10 ns a pixel of the 2^28 that are read at most, whatever a file's
// bytes unpack to.
constexpr double kRasterBase_s = 120, kRasterPerByte_s = 4e-6;
constexpr std::uint64_t kMemory_bytes = 6ull << 30;
constexpr int kPiece_values = 1 << 20;

std::string gdal_message() {
  const std::string text = base::gdal_message();
  return text.empty() ? "no message" : text;
}

/// Fills in a copy in memory: the file stays as it is.
bool interpolate(std::vector<double>& values, const std::vector<bool>& valid, int columns, int rows) {
  const GDALDriverH driver = gdal().GDALGetDriverByName("MEM");
  const GdalDataset copy(gdal().GDALCreate(driver, "", columns, rows, 1, GDT_Float64, nullptr));
  const GdalDataset mask(gdal().GDALCreate(driver, "", columns, rows, 1, GDT_Byte, nullptr));
  if (!copy || !mask) return false;
  std::vector<unsigned char> bytes(valid.size());
  for (std::size_t i = 0; i < valid.size(); ++i) bytes[i] = valid[i] ? 255 : 0;
  const GDALRasterBandH band = gdal().GDALGetRasterBand(copy.get(), 1),
                        mask_band = gdal().GDALGetRasterBand(mask.get(), 1);
  if (gdal().GDALRasterIO(band, GF_Write, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float64, 0, 0) !=
          CE_None ||
      gdal().GDALRasterIO(mask_band, GF_Write, 0, 0, columns, rows, bytes.data(), columns, rows, GDT_Byte, 0, 0) !=
          CE_None)
    return false;
  const double reach = std::hypot(columns, rows);
  return gdal().GDALFillNodata(band, mask_band, reach, 0, 0, nullptr, nullptr, nullptr) == CE_None &&
         gdal().GDALRasterIO(band, GF_Read, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float64, 0, 0) ==
             CE_None;
}

void read_reference(GDALDatasetH dataset, Raster& raster) {
  raster.georeferenced = gdal().GDALGetGeoTransform(dataset, raster.transform.data()) == CE_None;
  const OGRSpatialReferenceH srs = gdal().GDALGetSpatialRef(dataset);
  if (srs == nullptr) return;
  raster.geographic = gdal().OSRIsGeographic(srs) != 0;
  if (const char* code = gdal().OSRGetAuthorityCode(srs, nullptr)) raster.epsg = std::atoi(code);
  if (raster.epsg != 0) return;
  // ESRI .prj files name no code: take the database's best match when it is surely the same system (70: equal
  // but for names).
  int count = 0;
  int* confidence = nullptr;
  OGRSpatialReferenceH* matches = gdal().OSRFindMatches(srs, nullptr, &count, &confidence);
  if (count > 0 && confidence[0] >= 70)
    if (const char* code = gdal().OSRGetAuthorityCode(matches[0], nullptr)) raster.epsg = std::atoi(code);
  gdal().OSRFreeSRSArray(matches);
  gdal().VSIFree(confidence);
}

/// What the child found before any sample, as it hands it back.
struct Opened {
  int columns = 0, rows = 0, band_count = 0, epsg = 0;
  bool georeferenced = false, geographic = false, palette = false;
  std::array<double, 6> transform{};
};

bool fits(const Opened& opened, int count) {
  return double(opened.columns) * opened.rows * std::max(count, 1) <= double(1 << 28);
}
bool has_bands(const Opened& opened, int first_band, int count) {
  return count >= 1 && first_band + count - 1 <= opened.band_count;
}

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

/// In the child: GDAL's word on the file (empty: it was opened), what it is, then for each band asked for
/// GDAL's word (empty: it could be read), its nodata value and its samples.
void read_by_gdal(const std::string& file, int first_band, int count, base::Parcel& parcel) {
  const QuietGdal quiet;
  const GdalDataset dataset(gdal().GDALOpen(file.c_str(), GA_ReadOnly));
  const std::string wrong = dataset ? cut_short(dataset.get(), file) : gdal_message();
  parcel.text(wrong);
  if (!wrong.empty()) return;
  Raster raster;
  read_reference(dataset.get(), raster);
  Opened opened{gdal().GDALGetRasterXSize(dataset.get()),
                gdal().GDALGetRasterYSize(dataset.get()),
                gdal().GDALGetRasterCount(dataset.get()),
                raster.epsg,
                raster.georeferenced,
                raster.geographic,
                false,
                raster.transform};
  if (has_bands(opened, first_band, 1))
    opened.palette = gdal().GDALGetRasterColorTable(gdal().GDALGetRasterBand(dataset.get(), first_band)) != nullptr;
  parcel.value(opened);
  if (count == 0) count = opened.band_count - first_band + 1;
  if (!fits(opened, count) || !has_bands(opened, first_band, count)) return;
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(dataset.get(), first_band + i);
    int has_nodata = 0, block_columns = 0, block_rows = 1;
    const double hole = gdal().GDALGetRasterNoDataValue(band, &has_nodata);
    parcel.value(has_nodata != 0), parcel.value(hole);
    gdal().GDALGetBlockSize(band, &block_columns, &block_rows);
    // Whole rows of blocks at a time.
    const int step = std::clamp(kPiece_values / std::max(opened.columns, 1) / block_rows * block_rows,
                                std::min(block_rows, opened.rows), opened.rows);
    for (int row = 0; row < opened.rows; row += step) {
      const int rows = std::min(step, opened.rows - row);
      values.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(opened.columns));
      const bool read = gdal().GDALRasterIO(band, GF_Read, 0, row, opened.columns, rows, values.data(), opened.columns,
                                            rows, GDT_Float64, 0, 0) == CE_None;
      parcel.text(read ? "" : gdal_message());
      if (!read) return;
      parcel.list(values.data(), values.size());
    }
  }
}

/// Takes a band's samples as read_by_gdal() sends them; GDAL's word when they end early.
std::string take_band(base::Unpacked& read, std::vector<double>& values, std::size_t pixels) {
  values.reserve(pixels);
  while (values.size() < pixels) {
    std::string said = read.text();
    if (!said.empty()) return said;
    const auto piece = read.list<double>();
    values.insert(values.end(), piece.begin(), piece.end());
  }
  return "";
}

}  // namespace

std::optional<Raster> read_raster(const std::string& file, int first_band, int count, NoData nodata,
                                  const Where& asked_by, Problems& problems) {
  if (!check_readable(file, asked_by, problems)) return std::nullopt;
  base::ChildLimits limits;
  limits.cpu_s = kRasterBase_s + kRasterPerByte_s * static_cast<double>(std::filesystem::file_size(file));
  limits.memory_bytes = kMemory_bytes;
  gdal();  // loaded here, not by the child of each raster
  base::Unpacked read =
      base::in_limited_child(limits, [&](base::Parcel& parcel) { read_by_gdal(file, first_band, count, parcel); });
  const std::string said = read.end == base::ChildEnd::done ? read.text() : "it " + read.why;
  if (!said.empty()) {
    problems.add({file, 0, 0, ""}, "GDAL cannot read the raster", said,
                 "correct or convert the file; " + asked_by.text() + " names it");
    return std::nullopt;
  }
  const auto opened = read.value<Opened>();
  Raster raster;
  raster.file = file;
  raster.columns = opened.columns, raster.rows = opened.rows, raster.band_count = opened.band_count;
  raster.georeferenced = opened.georeferenced, raster.transform = opened.transform;
  raster.epsg = opened.epsg, raster.geographic = opened.geographic, raster.palette = opened.palette;
  if (count == 0) count = raster.band_count - first_band + 1;
  if (!fits(opened, count)) {
    problems.add({file, 0, 0, ""}, "raster is too large",
                 std::to_string(raster.columns) + " x " + std::to_string(raster.rows) + " pixels",
                 "at most 2^28 pixels; cut it with gdal_translate -projwin");
    return std::nullopt;
  }
  if (!has_bands(opened, first_band, count)) {
    problems.add(asked_by, "raster has no such band",
                 std::to_string(first_band + std::max(count, 1) - 1) + " of " + std::to_string(raster.band_count),
                 file);
    return std::nullopt;
  }
  const std::size_t pixels = static_cast<std::size_t>(raster.columns) * static_cast<std::size_t>(raster.rows);
  for (int i = 0; i < count; ++i) {
    const bool has_nodata = read.value<bool>();
    const double hole = read.value<double>();
    auto& values = raster.bands.emplace_back();
    if (const std::string failed = take_band(read, values, pixels); !failed.empty()) {
      problems.add({file, 0, 0, "band " + std::to_string(first_band + i)}, "raster is truncated or damaged", failed,
                   "restore the file");
      return std::nullopt;
    }
    auto& valid = raster.valid.emplace_back(values.size(), true);
    bool holes = false;
    for (std::size_t k = 0; k < values.size(); ++k) {
      valid[k] = std::isfinite(values[k]) && !(has_nodata && values[k] == hole);
      holes = holes || !valid[k];
    }
    if (!holes || nodata == NoData::mark) continue;
    const QuietGdal quiet;
    if (!interpolate(values, valid, raster.columns, raster.rows)) {
      problems.add({file, 0, 0, ""}, "cannot interpolate the posts without data", gdal_message(),
                   "fill them with gdal_fillnodata.py");
      return std::nullopt;
    }
    for (std::size_t k = 0; k < values.size(); ++k)
      valid[k] = std::isfinite(values[k]) && !(has_nodata && values[k] == hole);
  }
  return raster;
}

std::optional<GeoPlace> geographic_place(int epsg, double easting_m, double northing_m) {
  const QuietGdal quiet;
  const GdalSpatialReference projected(gdal().OSRNewSpatialReference(nullptr)),
      geographic(gdal().OSRNewSpatialReference(nullptr));
  if (gdal().OSRImportFromEPSG(projected.get(), epsg) != OGRERR_NONE ||
      gdal().OSRImportFromEPSG(geographic.get(), 4326) != OGRERR_NONE)
    return std::nullopt;
  if (gdal().OSRIsProjected(projected.get()) == 0) return std::nullopt;
  gdal().OSRSetAxisMappingStrategy(projected.get(), OAMS_TRADITIONAL_GIS_ORDER);
  gdal().OSRSetAxisMappingStrategy(geographic.get(), OAMS_TRADITIONAL_GIS_ORDER);
  const base::GdalOwned<&base::Gdal::OCTDestroyCoordinateTransformation> transform(
      gdal().OCTNewCoordinateTransformation(projected.get(), geographic.get()));
  if (!transform) return std::nullopt;
  // The second point lies 1 km to the grid's north.
  double x[2] = {easting_m, easting_m}, y[2] = {northing_m, northing_m + 1000.0};
  if (!gdal().OCTTransform(transform.get(), 2, x, y, nullptr)) return std::nullopt;
  if (!std::isfinite(x[0]) || !std::isfinite(y[0]) || !std::isfinite(x[1]) || !std::isfinite(y[1])) return std::nullopt;
  const double to_rad = M_PI / 180.0;
  const double lat1 = y[0] * to_rad, lat2 = y[1] * to_rad, dlon = (x[1] - x[0]) * to_rad;
  // Over 1 km the ellipsoid is a plane: east = N cos(lat) dlon, north = M dlat, both over N (radii of WGS
  // 84).
  const double e2 = 0.00669437999014;
  const double w2 = 1 - e2 * std::sin(lat1) * std::sin(lat1);
  const double meridian_over_prime = (1 - e2) / w2;  // M / N of WGS 84
  const double east = std::cos(0.5 * (lat1 + lat2)) * dlon, north = meridian_over_prime * (lat2 - lat1);
  return GeoPlace{x[0], y[0], std::atan2(east, north) / to_rad};
}

}  // namespace raycube::scene
