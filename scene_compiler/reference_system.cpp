#include "scene_compiler/reference_system.h"

#include <cmath>
#include <cstdlib>

#include "host/base/gdal_library.h"

namespace raycube::scene {
namespace {

using base::gdal;
using base::GdalSpatialReference;

GdalSpatialReference copy_without_heights(OGRSpatialReferenceH system) {
  GdalSpatialReference out(gdal().OSRClone(system));
  if (gdal().OSRIsCompound(out.get())) gdal().OSRStripVertical(out.get());
  return out;
}

int code_of(OGRSpatialReferenceH system) {
  if (const char* code = gdal().OSRGetAuthorityCode(system, nullptr)) return std::atoi(code);
  // ESRI .prj files name no code: take the database's best match when it is surely the same system (70: equal but for
  // names).
  int count = 0, epsg = 0;
  int* confidence = nullptr;
  OGRSpatialReferenceH* matches = gdal().OSRFindMatches(system, nullptr, &count, &confidence);
  if (count > 0 && confidence[0] >= 70)
    if (const char* code = gdal().OSRGetAuthorityCode(matches[0], nullptr)) epsg = std::atoi(code);
  gdal().OSRFreeSRSArray(matches);
  gdal().VSIFree(confidence);
  return epsg;
}

std::string wkt_of(OGRSpatialReferenceH system) {
  char* text = nullptr;
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  std::string out;
  if (gdal().OSRExportToWktEx(system, &text, options) == OGRERR_NONE && text) out = text;
  gdal().VSIFree(text);
  return out;
}

/// What PROJ said last, or what is known to be wrong.
std::string reason(const std::string& known) {
  const std::string said = base::gdal_message();
  // PROJ without its database knows no code at all.
  if (said.find("proj.db") != std::string::npos)
    return "PROJ's database proj.db was not found (" + said + "); install proj-data, or unset PROJ_LIB";
  return known;
}

}  // namespace

ReferenceSystem describe_system(OGRSpatialReferenceH system) {
  ReferenceSystem out;
  if (system == nullptr) return out;
  out.wkt = wkt_of(system);
  const GdalSpatialReference flat = copy_without_heights(system);
  out.geographic = gdal().OSRIsGeographic(flat.get()) != 0;
  out.epsg = code_of(flat.get());
  if (const char* name = gdal().OSRGetName(flat.get())) out.name = name;
  if (!out.geographic) out.unit_m = gdal().OSRGetLinearUnits(flat.get(), nullptr);
  if (gdal().OSRIsCompound(system)) {
    if (const char* name = gdal().OSRGetAttrValue(system, "VERT_CS", 0)) out.height_name = name;
    out.height_unit_m = gdal().OSRGetTargetLinearUnits(system, "VERT_CS", nullptr);
  }
  return out;
}

bool is_system(const std::string& wkt, int epsg) {
  const base::QuietGdal quiet;
  const GdalSpatialReference whole(gdal().OSRNewSpatialReference(wkt.c_str())),
      asked(gdal().OSRNewSpatialReference(nullptr));
  if (!whole || gdal().OSRImportFromEPSG(asked.get(), epsg) != OGRERR_NONE) return false;
  const GdalSpatialReference flat = copy_without_heights(whole.get());
  const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                                 "CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS", nullptr};
  return gdal().OSRIsSameEx(flat.get(), asked.get(), options) != 0;
}

std::optional<GeoPlace> geographic_place(int epsg, double easting_m, double northing_m, std::string* why) {
  const base::QuietGdal quiet;
  const auto none = [&](const std::string& known) -> std::optional<GeoPlace> {
    if (why) *why = reason(known);
    return std::nullopt;
  };
  const GdalSpatialReference projected(gdal().OSRNewSpatialReference(nullptr)),
      geographic(gdal().OSRNewSpatialReference(nullptr));
  if (gdal().OSRImportFromEPSG(projected.get(), epsg) != OGRERR_NONE)
    return none("PROJ knows no system EPSG:" + std::to_string(epsg));
  if (gdal().OSRImportFromEPSG(geographic.get(), 4326) != OGRERR_NONE) return none("PROJ knows no WGS 84");
  if (gdal().OSRIsProjected(projected.get()) == 0)
    return none("EPSG:" + std::to_string(epsg) + " is not a projected system");
  char* unit = nullptr;
  const double unit_m = gdal().OSRGetLinearUnits(projected.get(), &unit);
  if (std::abs(unit_m - 1) > 1e-12)
    return none("EPSG:" + std::to_string(epsg) + " is in units of " + (unit ? unit : "another length") +
                ", not in metres");
  gdal().OSRSetAxisMappingStrategy(projected.get(), OAMS_TRADITIONAL_GIS_ORDER);
  gdal().OSRSetAxisMappingStrategy(geographic.get(), OAMS_TRADITIONAL_GIS_ORDER);
  const base::GdalOwned<&base::Gdal::OCTDestroyCoordinateTransformation> transform(
      gdal().OCTNewCoordinateTransformation(projected.get(), geographic.get()));
  if (!transform) return none("PROJ cannot carry EPSG:" + std::to_string(epsg) + " to WGS 84");
  // The second point lies 1 km to the grid's north, the third 1 km to its east.
  constexpr double kStep_m = 1000;
  double x[3] = {easting_m, easting_m, easting_m + kStep_m}, y[3] = {northing_m, northing_m + kStep_m, northing_m};
  const bool carried = gdal().OCTTransform(transform.get(), 3, x, y, nullptr) != 0;
  for (const double value : {x[0], x[1], x[2], y[0], y[1], y[2]})
    if (!carried || !std::isfinite(value)) return none("the point lies outside of EPSG:" + std::to_string(epsg));
  const double to_rad = M_PI / 180.0;
  // Over 1 km the ellipsoid is a plane: east = N cos(lat) dlon, north = M dlat, both here over N (radii of WGS 84).
  constexpr double kEquator_m = 6378137.0, e2 = 0.00669437999014;
  const double latitude = y[0] * to_rad, w2 = 1 - e2 * std::sin(latitude) * std::sin(latitude),
               along_over_across = (1 - e2) / w2, across_m = kEquator_m / std::sqrt(w2);
  struct Way {
    double east, north;
  };
  const auto way = [&](int to) {
    const double there = y[to] * to_rad;
    return Way{std::cos(0.5 * (latitude + there)) * ((x[to] - x[0]) * to_rad), along_over_across * (there - latitude)};
  };
  const Way north = way(1), east = way(2);
  const auto scale = [&](const Way& over) { return kStep_m / (across_m * std::hypot(over.east, over.north)); };
  return GeoPlace{x[0], y[0], std::atan2(north.east, north.north) / to_rad, scale(north), scale(east)};
}

int utm_zone(const GeoPlace& place) {
  const int zone = 1 + static_cast<int>(std::floor(std::remainder(place.longitude_deg, 360.0) / 6 + 30)) % 60;
  return (place.latitude_deg < 0 ? 32700 : 32600) + zone;
}

}  // namespace raycube::scene
