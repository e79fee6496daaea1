#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_bounces() {
  return transport_knob<&scene::LidarTransport::max_bounces>(
      "bounces", "Scatterings that a pulse's light may have.", [](const Subject& s) {
        return with_own({1, 2, 3, 4}, s.lidar->transport.max_bounces);
      });
}

}  // namespace raycube::knobs
