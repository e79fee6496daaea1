// raycube lidar gff | dial: what belongs to LIDARs alone. Runs themselves are made by `render`.
#include "host/cli/lidar_dial.h"
#include "host/cli/lidar_gff.h"
#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_lidar() {
  Verb verb("lidar", "Draw a LIDAR's overlap against range; retrieve gas columns from its runs");
  verb.verbs = {verb_lidar_gff(), verb_lidar_dial()};
  return verb;
}

}  // namespace raycube::cli
