// Georeferencing of an image whose pixels lie on a map grid, north up.
#pragma once

#include "host/products/envi_header.h"

namespace raycube::products {

/// Fills `map info` and `coordinate system string` for an image whose upper left pixel *corner* lies at (easting_m,
/// northing_m) of the projected system epsg, with square or oblong pixels. Throws Error(input) when PROJ does not know epsg or
/// it is not projected in metres.
void set_map_grid(EnviHeader& header, int epsg, double easting_m, double northing_m, double pixel_x_m, double pixel_y_m);

}  // namespace raycube::products
