// Statistics of a band or channel as `raycube info` prints them.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "host/products/cube_statistics.h"

namespace raycube::cli {

nlohmann::ordered_json statistics_json(const products::BandStatistics& s);
/// "statistics", "min", "max" ... over the columns of statistics_line.
std::string statistics_title();
std::string statistics_line(const std::string& name, const products::BandStatistics& s);

}  // namespace raycube::cli
