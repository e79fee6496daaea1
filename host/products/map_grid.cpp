#include "host/products/map_grid.h"

#include <cmath>

#include <cpl_conv.h>
#include <cpl_error.h>
#include <fmt/format.h>
#include <ogr_spatialref.h>

#include "host/base/error.h"

namespace raycube::products {

void set_map_grid(EnviHeader& header, int epsg, double easting_m, double northing_m, double pixel_x_m, double pixel_y_m) {
  CPLPushErrorHandler(CPLQuietErrorHandler);
  OGRSpatialReference system;
  const bool known = system.importFromEPSG(epsg) == OGRERR_NONE;
  CPLPopErrorHandler();
  if (!known || !system.IsProjected() || std::abs(system.GetLinearUnits() - 1) > 1e-12)
    throw base::Error(base::Fault::input, fmt::format("epsg must be a projected system in metres that PROJ knows (found {}); "
                                                      "UTM north is 32601 to 32660", epsg));
  int north = 0;
  const int zone = system.GetUTMZone(&north);
  const char* datum = system.GetAttrValue("DATUM");
  const bool wgs84 = datum && std::string(datum).find("WGS_1984") != std::string::npos;
  const auto number = [](double value) { return fmt::format("{:.10g}", value); };
  header.map_info = {zone ? "UTM" : "Arbitrary", "1", "1", number(easting_m), number(northing_m), number(pixel_x_m), number(pixel_y_m)};
  if (zone) {
    header.map_info.push_back(std::to_string(zone));
    header.map_info.push_back(north ? "North" : "South");
  }
  header.map_info.push_back(wgs84 ? "WGS-84" : datum ? datum : "Unknown");
  header.map_info.push_back("units=Meters");
  char* text = nullptr;
  OGRSpatialReference esri(system);
  const char* const options[] = {"FORMAT=WKT1_ESRI", nullptr};
  if (esri.exportToWkt(&text, options) == OGRERR_NONE && text) header.coordinate_system = text;
  CPLFree(text);
}

}  // namespace raycube::products
