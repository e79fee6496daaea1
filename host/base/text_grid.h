// Grids of numbers written as text (ESRI, GRASS, Surfer), before GDAL reads their words as numbers of some type.
#pragma once

#include <string>

#include <gdal.h>

namespace raycube::base {

/// What GDAL passes over in a text grid; empty strings where it is none or is sound.
struct TextGrid {
  std::string wrong;   ///< words that are no numbers, or more or fewer of them than its header counts
  std::string beyond;  ///< the first number that the type which GDAL chose cannot hold: "'nan' is read as another ..."
};
TextGrid read_text_grid(GDALDatasetH dataset, const std::string& file);

}  // namespace raycube::base
