// GDAL is loaded by the first who asks, once, with its drivers; where it cannot be, one error says why and what to do.
#include <doctest/doctest.h>

#include <string>
#include <thread>
#include <vector>

#include "host/base/error.h"
#include "host/base/gdal_library.h"

using namespace raycube::base;

namespace {

std::string refusal(const std::string& library) {
  try {
    load_gdal(library);
  } catch (const Error& error) {
    CHECK(error.fault() == Fault::environment);
    return error.what();
  }
  FAIL(library << " was taken for GDAL");
  return "";
}

}  // namespace

TEST_CASE("a library that is not there, or is not GDAL, is told with the loader's reason and the package to install") {
  const std::string none = refusal("libgdal.so.none");
  CHECK(none.find("GDAL, which reads and writes rasters and maps, cannot be loaded (libgdal.so.none: ") == 0);
  CHECK(none.find("); install libgdal.so.") != std::string::npos);
  CHECK(none.find(", on Debian by apt install libgdal") != std::string::npos);
  // The first function of the list is looked for first.
  CHECK(refusal("libm.so.6").find("(libm.so.6 has no function CPLErrorReset); install ") != std::string::npos);
}

TEST_CASE("threads that ask at once get one GDAL with its drivers registered") {
  std::vector<const Gdal*> tables(8);
  std::vector<GDALDriverH> drivers(tables.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < tables.size(); ++i)
    threads.emplace_back([&, i] { drivers[i] = (tables[i] = &gdal())->GDALGetDriverByName("GTiff"); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < tables.size(); ++i) {
    CHECK(tables[i] == tables[0]);
    CHECK(drivers[i] != nullptr);
    CHECK(drivers[i] == drivers[0]);
  }
}

TEST_CASE("GDAL's messages are ours while it is quiet, and begin with none") {
  const auto open_nothing = [] { return GdalDataset(gdal().GDALOpen("/nonexistent/raster", GA_ReadOnly)); };
  {
    const QuietGdal quiet;
    CHECK(!open_nothing());
    CHECK(gdal_message().find("/nonexistent/raster") != std::string::npos);
  }
  const QuietGdal again;
  CHECK(gdal_message().empty());
}
