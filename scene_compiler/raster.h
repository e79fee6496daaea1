// Rasters through GDAL, which works in a child process under a limit; one band at a time, in the type of its file.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "host/base/gdal_band.h"
#include "scene_compiler/reference_system.h"
#include "scene_compiler/band_values.h"

namespace raycube::scene {

/// Bands of a raster, as its file declares them: scale, offset, masks and nodata values applied. transform: x = t0 + t1
/// c + t2 r, y = t3 + t4 c + t5 r of pixel corner (column c, row r).
struct Raster {
  std::string file;
  int columns = 0, rows = 0, band_count = 0;
  bool georeferenced = false;
  std::array<double, 6> transform{0, 1, 0, 0, 0, -1};
  ReferenceSystem system;
  std::vector<base::GdalBand> declared;  ///< of those asked for
  std::vector<BandValues> bands;         ///< those asked for, row by row from the raster's first row
  std::vector<std::vector<bool>> valid;  ///< false: nodata, masked, fully transparent or not finite
  std::size_t transparent = 0;           ///< pixels of the first band that count though their opacity is 0
};

enum class NoData { mark, interpolate };
/// Whether pixels that an alpha band makes fully transparent have values: those of pictures have colours.
enum class Transparent { has_no_value, has_a_value };

constexpr double kMostPixels = 1 << 28;  ///< of a raster, in all its bands

/// Which bands are read, and how.
struct RasterRequest {
  int first_band = 1;
  int count = 1;  ///< 0: to the last
  NoData nodata = NoData::mark;
  Transparent transparent = Transparent::has_no_value;
  double most_pixels = kMostPixels;  ///< in all bands, at most that many
  double made_bytes = 0;             ///< memory of what the caller makes of a pixel's values while it holds them
};

/// White of a picture: what the largest number of its first band's integers stands for, 255 or 65535 of 16 bits. Text
/// grids have integers of 32 bits, whatever they were made of: there it is the one of these that holds all values. 0:
/// they are no integers, or larger.
double white_of(const Raster& image);

/// Reads bands first_band .. first_band + count - 1. NoData::interpolate fills with GDALFillNodata (inverse distance
/// from the valid neighbours). A scale, an offset or an orientation that the file declares is told; turned by the
/// latter is what has no place on a map.
/// nullopt after reporting: missing, 0-byte, not a raster, no such band, truncated, more than `most_pixels` in all its
/// bands, or more than memory holds.
std::optional<Raster> read_raster(const std::string& file, const RasterRequest& request, const base::Where& asked_by,
                                  base::Problems& problems);

}  // namespace raycube::scene
