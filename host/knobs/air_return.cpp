#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_air_return() {
  Knob knob;
  knob.name = "air_return";
  knob.text = "Light that the air itself scatters back to the receiver.";
  knob.applies = [](const Subject& s) { return s.lidar != nullptr && !s.simulation.atmosphere.none; };
  knob.get = [](const Subject& s) { return s.lidar->transport.air_return ? 1.0 : 0.0; };
  knob.levels = [](const Subject&) { return std::vector<double>{0, 1}; };
  knob.set = [](const Subject& s, double level) { s.lidar->transport.air_return = level != 0; };
  knob.label = switch_label;
  return knob;
}

}  // namespace raycube::knobs
