// Bands of rasters as their files declare them. Every value that comes through GDAL is read here: heights, textures,
// maps, grids, regions. Scale and offset are applied; nodata values, masks and opacity say where there is none.
#pragma once

#include <string>
#include <vector>

typedef void* GDALRasterBandH;  // as gdal.h has it, which few need

namespace raycube::base {

/// What a file says of a band's numbers.
struct GdalBand {
  double scale = 1, offset = 0;  ///< value = scale * number in the file + offset
  std::string unit;              ///< as the file has it; empty: none
  std::string mask;              ///< "nodata", "mask", "alpha", "nodata and alpha"; empty: every number counts
  double no_data = 0;            ///< number in the file, where mask begins with "nodata"
  double most = 0;            ///< largest number of its kind of integers (65535 of 16 bits); 0: they are not integers
  bool palette = false;       ///< numbers of colours
  bool signed_bytes = false;  ///< of -128 to 127, which GDAL before 3.7 hands on as 0 to 255

  bool scaled() const { return scale != 1 || offset != 0; }
};

GdalBand describe_band(GDALRasterBandH band);

/// What is known of a pixel.
enum class Pixel : unsigned char {
  missing,      ///< by its nodata value or its mask, or not finite
  transparent,  ///< its opacity is 0; its value is what the file has
  sound
};

/// `rows` whole rows from `first_row`: the file's numbers, and what is known of each. False with GDAL's word in
/// gdal_message() where they cannot be read.
bool read_numbers(GDALRasterBandH band, const GdalBand& described, int first_row, int rows,
                  std::vector<double>& numbers, std::vector<Pixel>& known);
/// The same with values, scaled.
bool read_rows(GDALRasterBandH band, const GdalBand& described, int first_row, int rows, std::vector<double>& values,
               std::vector<Pixel>& known);

/// Metres that a unit's name stands for, as rasters and reference systems write it ("metre", "ft", "US survey foot");
/// 0: not known.
double metres_of(const std::string& unit);

}  // namespace raycube::base
