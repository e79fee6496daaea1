#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_subrays() {
  return transport_knob<&scene::LidarTransport::subrays>(
      "subrays", "Sub-rays of a pulse, or samples of an array's pixel.", [](const Subject& s) {
        return with_own({1, 4, 16, 64, 256, 1024}, s.lidar->transport.subrays);
      });
}

}  // namespace raycube::knobs
