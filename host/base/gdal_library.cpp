#include "host/base/gdal_library.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <dlfcn.h>

#include "host/base/error.h"

namespace raycube::base {
namespace {

Error cannot_be_loaded(const std::string& why) {
  return {Fault::environment, "GDAL, which reads and writes rasters and maps, cannot be loaded (" + why +
                                  "); install " RAYCUBE_GDAL_LIBRARY
                                  ", on Debian by apt install " RAYCUBE_GDAL_PACKAGE};
}

constexpr std::array kDrivers = {
#define RAYCUBE_GDAL_DRIVER(name) std::string_view(name),
#include "host/base/gdal_drivers.def"
#undef RAYCUBE_GDAL_DRIVER
};

/// Registers the drivers of our list, and closes the ways to the network and to code that files may name: plugins,
/// Python in virtual rasters, addresses as names of files.
void register_drivers(const Gdal& of) {
  for (const auto& [name, value] :
       {std::pair{"GDAL_DRIVER_PATH", "disable"}, std::pair{"GDAL_VRT_ENABLE_PYTHON", "NO"},
        std::pair{"CPL_VSIL_CURL_ALLOWED_FILENAME", "none"}, std::pair{"PROJ_NETWORK", "OFF"}})
    of.CPLSetConfigOption(name, value);
  of.CPLSetErrorHandler(of.CPLQuietErrorHandler);  // its word comes through our own errors
  of.GDALAllRegister();
  for (int i = of.GDALGetDriverCount() - 1; i >= 0; --i) {
    const GDALDriverH driver = of.GDALGetDriver(i);
    if (std::find(kDrivers.begin(), kDrivers.end(), of.GDALGetDriverShortName(driver)) == kDrivers.end())
      of.GDALDeregisterDriver(driver);
  }
}

}  // namespace

Gdal load_gdal(const std::string& library) {
  // RTLD_LOCAL: the names of its libraries stay theirs. RTLD_NOW: what they lack is told here, not by a crash later.
  void* const loaded = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!loaded) throw cannot_be_loaded(::dlerror());
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(loaded, name));
    if (!function) throw cannot_be_loaded(library + " has no function " + name);
  };
  Gdal out;
#define RAYCUBE_GDAL(name) find(out.name, #name);
#include "host/base/gdal_functions.def"
#undef RAYCUBE_GDAL
  return out;
}

const Gdal& gdal() {
  static const Gdal loaded = [] {
    const Gdal out = load_gdal(RAYCUBE_GDAL_LIBRARY);
    register_drivers(out);
    return out;
  }();
  return loaded;
}

}  // namespace raycube::base
