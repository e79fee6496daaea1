// Images whose pixels look at the ground each where it does, put on a north-up map.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "host/base/output_file.h"
#include "host/products/envi_header.h"

namespace raycube::analysis {

struct OrthoRequest {
  std::string image;                   ///< data file or header of an ENVI image with location.img beside it
  std::optional<double> pixel_m;       ///< of the map; empty: about that of the image
  std::string resampling = "nearest";  ///< nearest, bilinear, cubic, average
};

struct Ortho {
  std::int64_t samples = 0, lines = 0, bands = 0;
  double easting_m = 0, northing_m = 0, pixel_m = 0;  ///< upper left corner, and a pixel
  int epsg = 0;
};

/// Writes ortho.img and its header into the set, which is made when the image is known to have a map: float32,
/// physical values, NaN where no pixel of the image looks. Places of pixels between their middles are GDAL's
/// geolocation arrays'; the nearest pixel's values are taken as they are, others are mixed. Block by block.
/// Error(input) where the image has no places, or some of its pixels look past the ground.
Ortho orthorectify(const OrthoRequest& request, const std::function<base::OutputSet&()>& set);

}  // namespace raycube::analysis
