#include "scene_compiler/raster.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <mutex>

#include "scene_compiler/csv_file.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

/// GDAL's messages come through us, not through stderr.
struct QuietGdal {
  QuietGdal() {
    static std::once_flag once;
    std::call_once(once, GDALAllRegister);
    CPLPushErrorHandler(CPLQuietErrorHandler);
    CPLErrorReset();
  }
  ~QuietGdal() { CPLPopErrorHandler(); }
};

struct CloseDataset {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<void, CloseDataset>;

struct DestroySrs {
  void operator()(void* srs) const { OSRDestroySpatialReference(srs); }
};
using Srs = std::unique_ptr<void, DestroySrs>;

std::string gdal_message() {
  const std::string text = CPLGetLastErrorMsg();
  return text.empty() ? "no message" : text;
}

/// Fills in a copy in memory: the file stays as it is.
bool interpolate(std::vector<double>& values, const std::vector<bool>& valid, int columns, int rows) {
  const GDALDriverH driver = GDALGetDriverByName("MEM");
  const Dataset copy(GDALCreate(driver, "", columns, rows, 1, GDT_Float64, nullptr));
  const Dataset mask(GDALCreate(driver, "", columns, rows, 1, GDT_Byte, nullptr));
  if (!copy || !mask) return false;
  std::vector<unsigned char> bytes(valid.size());
  for (std::size_t i = 0; i < valid.size(); ++i) bytes[i] = valid[i] ? 255 : 0;
  const GDALRasterBandH band = GDALGetRasterBand(copy.get(), 1), mask_band = GDALGetRasterBand(mask.get(), 1);
  if (GDALRasterIO(band, GF_Write, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float64, 0, 0) !=
          CE_None ||
      GDALRasterIO(mask_band, GF_Write, 0, 0, columns, rows, bytes.data(), columns, rows, GDT_Byte, 0, 0) !=
          CE_None)
    return false;
  const double reach = std::hypot(columns, rows);
  return GDALFillNodata(band, mask_band, reach, 0, 0, nullptr, nullptr, nullptr) == CE_None &&
         GDALRasterIO(band, GF_Read, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float64, 0, 0) ==
             CE_None;
}

void read_reference(GDALDatasetH dataset, Raster& raster) {
  raster.georeferenced = GDALGetGeoTransform(dataset, raster.transform.data()) == CE_None;
  const OGRSpatialReferenceH srs = GDALGetSpatialRef(dataset);
  if (srs == nullptr) return;
  raster.geographic = OSRIsGeographic(srs) != 0;
  if (const char* code = OSRGetAuthorityCode(srs, nullptr)) raster.epsg = std::atoi(code);
  if (raster.epsg != 0) return;
  // ESRI .prj files name no code: take the database's best match when it is surely the same system (70: equal
  // but for names).
  int count = 0;
  int* confidence = nullptr;
  OGRSpatialReferenceH* matches = OSRFindMatches(srs, nullptr, &count, &confidence);
  if (count > 0 && confidence[0] >= 70)
    if (const char* code = OSRGetAuthorityCode(matches[0], nullptr)) raster.epsg = std::atoi(code);
  OSRFreeSRSArray(matches);
  CPLFree(confidence);
}

}  // namespace

std::optional<Raster> read_raster(const std::string& file, int first_band, int count, NoData nodata,
                                  const Where& asked_by, Problems& problems) {
  if (!check_readable(file, asked_by, problems)) return std::nullopt;
  const QuietGdal quiet;
  const Dataset dataset(GDALOpen(file.c_str(), GA_ReadOnly));
  if (!dataset) {
    problems.add({file, 0, 0, ""}, "GDAL cannot read the raster", gdal_message(),
                 "correct or convert the file; " + asked_by.text() + " names it");
    return std::nullopt;
  }
  Raster raster;
  raster.file = file;
  raster.columns = GDALGetRasterXSize(dataset.get());
  raster.rows = GDALGetRasterYSize(dataset.get());
  raster.band_count = GDALGetRasterCount(dataset.get());
  if (count == 0) count = raster.band_count - first_band + 1;
  const double pixels = double(raster.columns) * raster.rows;
  if (pixels * std::max(count, 1) > double(1 << 28)) {
    problems.add({file, 0, 0, ""}, "raster is too large",
                 std::to_string(raster.columns) + " x " + std::to_string(raster.rows) + " pixels",
                 "at most 2^28 pixels; cut it with gdal_translate -projwin");
    return std::nullopt;
  }
  if (count < 1 || first_band + count - 1 > raster.band_count) {
    problems.add(asked_by, "raster has no such band",
                 std::to_string(first_band) + " of " + std::to_string(raster.band_count), file);
    return std::nullopt;
  }
  read_reference(dataset.get(), raster);
  for (int i = 0; i < count; ++i) {
    const GDALRasterBandH band = GDALGetRasterBand(dataset.get(), first_band + i);
    auto& values = raster.bands.emplace_back(static_cast<std::size_t>(pixels));
    auto& valid = raster.valid.emplace_back(values.size(), true);
    if (GDALRasterIO(band, GF_Read, 0, 0, raster.columns, raster.rows, values.data(), raster.columns,
                     raster.rows, GDT_Float64, 0, 0) != CE_None) {
      problems.add({file, 0, 0, "band " + std::to_string(first_band + i)}, "raster is truncated or damaged",
                   gdal_message(), "restore the file");
      return std::nullopt;
    }
    int has_nodata = 0;
    const double hole = GDALGetRasterNoDataValue(band, &has_nodata);
    bool holes = false;
    for (std::size_t k = 0; k < values.size(); ++k) {
      valid[k] = std::isfinite(values[k]) && !(has_nodata && values[k] == hole);
      holes = holes || !valid[k];
    }
    if (!holes || nodata == NoData::mark) continue;
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
  const Srs projected(OSRNewSpatialReference(nullptr)), geographic(OSRNewSpatialReference(nullptr));
  if (OSRImportFromEPSG(projected.get(), epsg) != OGRERR_NONE ||
      OSRImportFromEPSG(geographic.get(), 4326) != OGRERR_NONE)
    return std::nullopt;
  if (OSRIsProjected(projected.get()) == 0) return std::nullopt;
  OSRSetAxisMappingStrategy(projected.get(), OAMS_TRADITIONAL_GIS_ORDER);
  OSRSetAxisMappingStrategy(geographic.get(), OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<void, void (*)(void*)> transform(
      OCTNewCoordinateTransformation(projected.get(), geographic.get()),
      [](void* t) { OCTDestroyCoordinateTransformation(static_cast<OGRCoordinateTransformationH>(t)); });
  if (!transform) return std::nullopt;
  // The second point lies 1 km to the grid's north.
  double x[2] = {easting_m, easting_m}, y[2] = {northing_m, northing_m + 1000.0};
  if (!OCTTransform(static_cast<OGRCoordinateTransformationH>(transform.get()), 2, x, y, nullptr))
    return std::nullopt;
  if (!std::isfinite(x[0]) || !std::isfinite(y[0]) || !std::isfinite(x[1]) || !std::isfinite(y[1]))
    return std::nullopt;
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
