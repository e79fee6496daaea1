// Where a run's products go.
#pragma once

#include <string>

#include "host/base/output_file.h"

namespace raycube::run {

/// A folder for one instrument, and what its run.json cannot know of itself.
struct Destination {
  std::string folder;
  base::IfExists if_exists = base::IfExists::refuse;
  std::string command;  ///< the command line, or what else asked for the run
  double load_s = 0;    ///< that loading the scene took
};

}  // namespace raycube::run
