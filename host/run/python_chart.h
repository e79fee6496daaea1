// Charts drawn by a script of host/plots with the system's Python and matplotlib.
#pragma once

#include <string>

#include "host/base/output_file.h"

namespace raycube::run {

/// Runs the script on figures (JSON) and writes the PNG it draws to `chart`, with the figures beside it under the
/// ending .json; returns the figures' name. Neither file is there unless both are whole.
std::string draw_chart(const std::string& script, const std::string& figures_json, const std::string& chart,
                       base::IfExists if_exists);

/// The same into files that are begun already, neither published.
void draw_into(const std::string& script, base::OutputFile& figures, base::OutputFile& picture);

/// Runs a script of host/plots on a file of figures (JSON) that says where to draw. Throws Error(environment) when
/// Python or matplotlib is missing.
void run_plot(const std::string& script, const std::string& figures);
/// Appends what lies at `path`, which a script was to write.
void append_drawn(base::OutputFile& out, const std::string& path);

}  // namespace raycube::run
