#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_view_nodes() {
  return plan_knob<&scene::PlanOverrides::view_nodes>(
      "view_nodes", "Nodes over the secant of the view zenith, linear between.", node_levels);
}

}  // namespace raycube::knobs
