// Rasters and outlines opened through GDAL, after a look at what GDAL passes over in silence.
#pragma once

#include <string>
#include <vector>

#include "host/base/gdal_band.h"
#include "host/base/gdal_library.h"

namespace raycube::base {

/// What all sources of a virtual raster declare alike of their numbers, and it does not: true of its own, which are
/// those.
struct SharedBySources {
  double scale = 1, offset = 0;
  std::string unit;
};

struct OpenedByGdal {
  GdalDataset set;                ///< none: it cannot be used
  std::string wrong;              ///< why not, by us or by GDAL; empty where it can
  bool refused = false;           ///< by us: GDAL opened it
  std::vector<std::string> told;  ///< what sources of a virtual raster declare and it leaves out, each kind once
  SharedBySources shared;
};

/// What the file says of a band's numbers, with what its sources share.
GdalBand describe_band(const OpenedByGdal& opened, GDALRasterBandH band);

/// Opens a file to read. kinds: GDAL_OF_RASTER, GDAL_OF_VECTOR or both. Refused although GDAL reads them, as zeros: raw
/// files that end before their header says, and text grids (ESRI, GRASS, Surfer) with words, or with more or fewer
/// numbers than their header counts; complex numbers; a virtual raster where one of its sources is refused. Text grids
/// have doubles where GDAL's integers do not hold what they say.
OpenedByGdal open_by_gdal(const std::string& file, unsigned kinds = GDAL_OF_RASTER);

}  // namespace raycube::base
