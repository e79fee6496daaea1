// Pipes, devices and sockets that GDAL would open with a raster: opening a pipe waits for its writer, and a device may
// never end.
#pragma once

#include <string>

namespace raycube::base {

/// "NAME, which is a pipe", of the files that GDAL looks for beside this one (.prj, .aux.xml, world files, headers), of
/// those that a virtual raster takes its values from, and of theirs. Empty: there is none.
std::string special_around(const std::string& file);

}  // namespace raycube::base
