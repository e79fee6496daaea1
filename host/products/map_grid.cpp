#include "host/products/map_grid.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/gdal_library.h"

namespace raycube::products {
namespace {

using base::gdal;

base::GdalSpatialReference projected_system(int epsg) {
  base::GdalSpatialReference system(gdal().OSRNewSpatialReference(nullptr));
  const auto known = [&] {
    const base::QuietGdal quiet;
    return gdal().OSRImportFromEPSG(system.get(), epsg) == OGRERR_NONE;
  };
  if (!known() || !gdal().OSRIsProjected(system.get()) ||
      std::abs(gdal().OSRGetLinearUnits(system.get(), nullptr) - 1) > 1e-12)
    throw base::Error(base::Fault::input,
                      fmt::format("epsg must be a projected system in metres that PROJ knows (found {}); "
                                  "UTM north is 32601 to 32660",
                                  epsg));
  return system;
}

std::string wkt_of(const base::GdalSpatialReference& system, const char* format) {
  char* text = nullptr;
  const char* const options[] = {format, nullptr};
  std::string out;
  if (gdal().OSRExportToWktEx(system.get(), &text, options) == OGRERR_NONE && text) out = text;
  gdal().VSIFree(text);
  return out;
}

}  // namespace

std::optional<MapGrid> find_map_grid(std::int64_t samples, std::int64_t lines,
                                     const std::function<void(std::int64_t line, double* values)>& read_line) {
  if (samples < 2 || lines < 2) return std::nullopt;
  constexpr double kOff_px = 0.05;
  std::vector<double> values(static_cast<std::size_t>(samples) * 3);
  read_line(lines - 1, values.data());
  const double last_northing = values[1];
  read_line(0, values.data());
  const double first_easting = values[0], first_northing = values[1];
  const double x_m = (values[values.size() - 3] - first_easting) / static_cast<double>(samples - 1);
  const double y_m = (first_northing - last_northing) / static_cast<double>(lines - 1);
  if (!(x_m > 0 && y_m > 0)) return std::nullopt;  // NaN too
  for (std::int64_t line = 0; line < lines; ++line) {
    read_line(line, values.data());
    for (std::int64_t sample = 0; sample < samples; ++sample) {
      const double off_x = values[sample * 3] - first_easting - x_m * static_cast<double>(sample);
      const double off_y = values[sample * 3 + 1] - first_northing + y_m * static_cast<double>(line);
      if (!(std::abs(off_x) <= kOff_px * x_m && std::abs(off_y) <= kOff_px * y_m)) return std::nullopt;
    }
  }
  return MapGrid{first_easting - x_m / 2, first_northing + y_m / 2, x_m, y_m};
}

void set_map_grid(EnviHeader& header, int epsg, double easting_m, double northing_m, double pixel_x_m,
                  double pixel_y_m) {
  const base::GdalSpatialReference system = projected_system(epsg);
  int north = 0;
  const int zone = gdal().OSRGetUTMZone(system.get(), &north);
  const char* datum = gdal().OSRGetAttrValue(system.get(), "DATUM", 0);
  const bool wgs84 = datum && std::string(datum).find("WGS_1984") != std::string::npos;
  const auto number = [](double value) { return fmt::format("{:.10g}", value); };
  header.map_info = {zone ? "UTM" : "Arbitrary", "1", "1", number(easting_m), number(northing_m), number(pixel_x_m),
                     number(pixel_y_m)};
  if (zone) {
    header.map_info.push_back(std::to_string(zone));
    header.map_info.push_back(north ? "North" : "South");
  }
  header.map_info.push_back(wgs84 ? "WGS-84" : datum ? datum : "Unknown");
  header.map_info.push_back("units=Meters");
  header.coordinate_system = wkt_of(system, "FORMAT=WKT1_ESRI");
}

std::string projected_wkt(int epsg) { return wkt_of(projected_system(epsg), "FORMAT=WKT1_GDAL"); }

}  // namespace raycube::products
