// GDAL, loaded by the first who calls it: it brings ninety libraries, which take the dynamic linker 0.09 s, and most
// commands read no raster. Types and macros are those of its headers; calls go through gdal(), and a direct one does
// not link.
#pragma once

#include <memory>
#include <string>

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

namespace raycube::base {

/// GDAL's functions under their own names (gdal_functions.def).
struct Gdal {
#define RAYCUBE_GDAL(name) decltype(&::name) name;
#include "host/base/gdal_functions.def"
#undef RAYCUBE_GDAL
};

/// The GDAL whose headers we were compiled with, with the drivers of gdal_drivers.def alone: files come from strangers,
/// and some drivers fetch addresses or run code that a file names. Nothing is read over a network. Loaded once,
/// whichever thread asks first. Throws Error(environment) where it cannot be. A child process that shall read has it
/// from its parent, which asks before.
const Gdal& gdal();

/// Its functions from a library of any name; registers no drivers. For gdal(), and for tests of its errors.
Gdal load_gdal(const std::string& library);

/// GDAL's word on what it could not do last; empty where it said nothing.
inline std::string gdal_message() { return gdal().CPLGetLastErrorMsg(); }

/// While it lives GDAL's messages come through us, not through stderr; begins with none.
class QuietGdal {
 public:
  QuietGdal() {
    gdal().CPLPushErrorHandler(gdal().CPLQuietErrorHandler);
    gdal().CPLErrorReset();
  }
  ~QuietGdal() { gdal().CPLPopErrorHandler(); }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

/// What GDAL made, given back to it by the function of the table that `Free` names.
template <auto Free>
struct GdalFrees {
  template <class T>
  void operator()(T* made) const {
    (gdal().*Free)(made);
  }
};
template <auto Free, class T = void>
using GdalOwned = std::unique_ptr<T, GdalFrees<Free>>;
using GdalDataset = GdalOwned<&Gdal::GDALClose>;
using GdalSpatialReference = GdalOwned<&Gdal::OSRDestroySpatialReference>;

}  // namespace raycube::base
