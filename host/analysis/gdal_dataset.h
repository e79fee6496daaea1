// GDAL's data sets, closed when nobody holds them.
#pragma once

#include <memory>

#include <gdal_priv.h>

namespace raycube::analysis {

struct ClosesDataset {
  void operator()(GDALDataset* set) const { GDALClose(set); }
};
using Dataset = std::unique_ptr<GDALDataset, ClosesDataset>;

}  // namespace raycube::analysis
