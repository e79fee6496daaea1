#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_subrays() {
  Knob knob;
  knob.name = "subrays";
  knob.text = "Sub-rays of a pulse, or samples of an array's pixel.";
  knob.applies = [](const Subject& s) { return s.lidar != nullptr; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.lidar->transport.subrays); };
  knob.levels = [](const Subject& s) { return with_own({1, 4, 16, 64, 256, 1024}, s.lidar->transport.subrays); };
  knob.set = [](const Subject& s, double level) { s.lidar->transport.subrays = static_cast<int>(std::lround(level)); };
  knob.label = whole_label;
  return knob;
}

}  // namespace raycube::knobs
