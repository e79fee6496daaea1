#include <algorithm>
#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_line_nodes() {
  Knob knob;
  knob.name = "line_nodes";
  knob.text = "Gauss-Hermite nodes of a laser line with a width.";
  knob.applies = [](const Subject& s) {
    return s.lidar != nullptr && std::any_of(s.lidar->pulse.lines.begin(), s.lidar->pulse.lines.end(),
                                             [](const auto& line) { return line.fwhm_um > 0; });
  };
  knob.get = [](const Subject& s) { return static_cast<double>(s.lidar->transport.line_nodes); };
  knob.levels = [](const Subject& s) { return with_own({1, 2, 4, 8, 16, 32, 64}, s.lidar->transport.line_nodes); };
  knob.set = [](const Subject& s, double level) {
    s.lidar->transport.line_nodes = static_cast<int>(std::lround(level));
  };
  knob.label = whole_label;
  return knob;
}

}  // namespace raycube::knobs
