// A GDAL virtual raster over an image whose pixels look at the ground each where it does: `gdalwarp -geoloc` and what
// builds on GDAL put it on a map.
#pragma once

#include <string>

#include "host/products/envi_header.h"

namespace raycube::products {

/// XML of NAME.vrt beside `image` (its file's name, float32 or uint16 as the header says) and `location`, whose first
/// two bands are easting and northing of the pixels' middles in `wkt`. Bands have the header's names or wavelengths.
std::string geolocated_vrt(const EnviHeader& header, const std::string& image, const std::string& location,
                           const std::string& wkt);

}  // namespace raycube::products
