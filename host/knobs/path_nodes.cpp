#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_path_nodes() {
  return plan_knob<&scene::PlanOverrides::path_nodes>(
      "path_nodes", "Nodes of path radiance along each of its two axes of direction, linear between.", node_levels);
}

}  // namespace raycube::knobs
