#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_height_nodes() {
  return plan_knob<&scene::PlanOverrides::height_nodes>("height_nodes",
                                                        "Nodes over the targets' height, linear between.", node_levels);
}

}  // namespace raycube::knobs
