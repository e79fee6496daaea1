// Charts drawn by a script of host/plots with the system's Python and matplotlib.
#pragma once

#include <string>

#include "host/base/output_file.h"

namespace raycube::cli {

/// Runs the script on figures (JSON) and writes the PNG it draws to `chart`, with the figures beside it under the ending .json;
/// returns the figures' name. Neither file is there unless both are whole.
std::string draw_chart(const std::string& script, const std::string& figures_json, const std::string& chart, base::IfExists if_exists);

}  // namespace raycube::cli
