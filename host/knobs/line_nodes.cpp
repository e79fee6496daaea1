#include <algorithm>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_line_nodes() {
  Knob knob = transport_knob<&scene::LidarTransport::line_nodes>(
      "line_nodes", "Gauss-Hermite nodes of a laser line with a width.", [](const Subject& s) {
        return with_own({1, 2, 4, 8, 16, 32, 64}, s.lidar->transport.line_nodes);
      });
  knob.applies = [](const Subject& s) {
    return s.lidar != nullptr && std::any_of(s.lidar->pulse.lines.begin(), s.lidar->pulse.lines.end(),
                                             [](const auto& line) { return line.fwhm_um > 0; });
  };
  return knob;
}

}  // namespace raycube::knobs
