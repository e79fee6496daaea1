#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_sky_rank() {
  return plan_knob<&scene::PlanOverrides::sky_rank>("sky_rank", "Components of the sunlit sky.", [](const Subject&) {
    return std::vector<double>{0, 1, 2, 3, 4};
  });
}

}  // namespace raycube::knobs
