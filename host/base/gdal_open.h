// Rasters and outlines opened through GDAL, after a look at what GDAL passes over in silence.
#pragma once

#include <string>

#include "host/base/gdal_library.h"

namespace raycube::base {

struct OpenedByGdal {
  GdalDataset set;    ///< none: it cannot be used
  std::string wrong;  ///< why not, by us or by GDAL; empty where it can
};

/// Opens a file to read. kinds: GDAL_OF_RASTER, GDAL_OF_VECTOR or both. Refused although GDAL reads them, as zeros: raw
/// files that end before their header says, and ESRI text grids with words, or with more or fewer numbers than their
/// header counts.
OpenedByGdal open_by_gdal(const std::string& file, unsigned kinds = GDAL_OF_RASTER);

}  // namespace raycube::base
