#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/knobs/knob.h"

namespace raycube::knobs {

/// The gate keeps its start and reaches at least as far as before.
Knob knob_bin_ns() {
  Knob knob;
  knob.name = "bin_ns";
  knob.unit = "ns";
  knob.text = "Width of a time bin; the gate stays where it is.";
  knob.applies = [](const Subject& s) { return s.lidar != nullptr && s.lidar->gate.bins >= 8; };
  knob.get = [](const Subject& s) { return 1e9 * s.lidar->gate.bin_s; };
  knob.levels = [](const Subject& s) {
    const double own = 1e9 * s.lidar->gate.bin_s;
    return std::vector<double>{4 * own, 2 * own, own};
  };
  knob.set = [](const Subject& s, double level) {
    scene::LidarGate& gate = s.lidar->gate;
    const double length_s = gate.bins * gate.bin_s;
    gate.bin_s = 1e-9 * level;
    gate.bins = std::max(1, static_cast<int>(std::ceil(length_s / gate.bin_s - 1e-6)));
  };
  knob.label = [](double level) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", level);
    return std::string(text);
  };
  return knob;
}

}  // namespace raycube::knobs
