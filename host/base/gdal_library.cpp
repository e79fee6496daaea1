#include "host/base/gdal_library.h"

#include <dlfcn.h>

#include "host/base/error.h"

namespace raycube::base {
namespace {

Error cannot_be_loaded(const std::string& why) {
  return {Fault::environment, "GDAL, which reads and writes rasters and maps, cannot be loaded (" + why +
                                  "); install " RAYCUBE_GDAL_LIBRARY
                                  ", on Debian by apt install " RAYCUBE_GDAL_PACKAGE};
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
    out.GDALAllRegister();
    return out;
  }();
  return loaded;
}

}  // namespace raycube::base
