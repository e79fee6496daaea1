// LAZ: the points of a LAS file compressed without loss, by laspy and lazrs (PyPI), since Debian 12 has no library
// for it.
#pragma once

#include <string>

namespace raycube::run {

/// A Python that has laspy and lazrs: RAYCUBE_PYTHON where that is set, else the virtual environment of a build
/// (ci/setup), else the system's. Throws Error(environment) where none has, which names those that were tried, and
/// where the script that will be run is missing.
std::string laz_python();

/// Writes the points of `las` to `laz`. Throws Error(environment) when the script fails.
void write_laz(const std::string& python, const std::string& las, const std::string& laz);

}  // namespace raycube::run
