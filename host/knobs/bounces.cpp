#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_bounces() {
  Knob knob;
  knob.name = "bounces";
  knob.text = "Scatterings that a pulse's light may have.";
  knob.applies = [](const Subject& s) { return s.lidar != nullptr; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.lidar->transport.max_bounces); };
  knob.levels = [](const Subject& s) { return with_own({1, 2, 3, 4}, s.lidar->transport.max_bounces); };
  knob.set = [](const Subject& s, double level) {
    s.lidar->transport.max_bounces = static_cast<int>(std::lround(level));
  };
  knob.label = whole_label;
  return knob;
}

}  // namespace raycube::knobs
