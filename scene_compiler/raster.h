// Rasters through GDAL, which works in a child process under a limit; one band at a time, in double.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::scene {

/// A band of a raster. transform: x = t0 + t1 c + t2 r, y = t3 + t4 c + t5 r of pixel corner (column c, row
/// r).
struct Raster {
  std::string file;
  int columns = 0, rows = 0, band_count = 0;
  bool georeferenced = false;
  std::array<double, 6> transform{0, 1, 0, 0, 0, -1};
  int epsg = 0;                            ///< 0: unknown
  bool geographic = false;                 ///< degrees
  bool palette = false;                    ///< the first band asked for holds numbers of colours
  std::vector<std::vector<double>> bands;  ///< those asked for, row by row from the raster's first row
  std::vector<std::vector<bool>> valid;    ///< false: nodata or not finite
};

enum class NoData { mark, interpolate };

/// Reads bands first_band .. first_band + count - 1 (count 0: to the last). NoData::interpolate fills with
/// GDALFillNodata (inverse distance from the valid neighbours). nullopt after reporting: missing, 0-byte, not
/// a raster, no such band, truncated, or more than 2^28 pixels.
std::optional<Raster> read_raster(const std::string& file, int first_band, int count, NoData nodata,
                                  const base::Where& asked_by, base::Problems& problems);

/// Longitude, latitude (degrees, WGS 84) of a point of a projected system, and the azimuth of its grid north
/// against true north (degrees, clockwise positive); nullopt for an unknown code.
struct GeoPlace {
  double longitude_deg = 0, latitude_deg = 0, grid_north_azimuth_deg = 0;
};
std::optional<GeoPlace> geographic_place(int epsg, double easting_m, double northing_m);

}  // namespace raycube::scene
