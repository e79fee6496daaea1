#include "host/base/data_folder.h"

#include <cstdlib>
#include <system_error>

#include "host/base/error.h"

namespace raycube::base {

std::filesystem::path data_folder() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (const char* named = std::getenv("RAYCUBE_DATA"); named && *named) {
    if (fs::is_directory(named, ignored)) return named;
    throw Error(Fault::environment,
                std::string("RAYCUBE_DATA is not a folder (found ") + named + "); unset it or correct it");
  }
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  const fs::path installed = program.parent_path() / "share/raycube", built = program / "share/raycube";
  if (fs::is_directory(installed, ignored)) return installed;
  if (fs::is_directory(built, ignored)) return built;
  throw Error(Fault::environment, "the program's data are missing (looked for " + installed.string() + " and " +
                                      built.string() + "); install it whole, or set RAYCUBE_DATA");
}

}  // namespace raycube::base
