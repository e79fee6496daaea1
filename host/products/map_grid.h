// Georeferencing of an image whose pixels lie on a map grid, north up.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "host/products/envi_header.h"

namespace raycube::products {

/// A north-up grid: the upper left pixel *corner* and the pixel's size, m.
struct MapGrid {
  double easting_m = 0, northing_m = 0, pixel_x_m = 0, pixel_y_m = 0;
};

/// The grid on which an image's pixels look at the ground, when they do: every pixel centre within 0.05 of a pixel of
/// it, line 0 the northernmost, at least two lines and samples, no pixel that looks past the ground. read_line fills
/// easting, northing and height of every sample of a line.
std::optional<MapGrid> find_map_grid(std::int64_t samples, std::int64_t lines,
                                     const std::function<void(std::int64_t line, double* values)>& read_line);

/// OGC WKT 1 (as LAS wants it) of the projected system epsg. Throws Error(input) as set_map_grid does.
std::string projected_wkt(int epsg);

/// Fills `map info` and `coordinate system string` for an image whose upper left pixel *corner* lies at (easting_m,
/// northing_m) of the projected system epsg, with square or oblong pixels. Throws Error(input) when PROJ does not know
/// epsg or it is not projected in metres.
void set_map_grid(EnviHeader& header, int epsg, double easting_m, double northing_m, double pixel_x_m,
                  double pixel_y_m);

}  // namespace raycube::products
