#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_bounces() {
  Knob knob;
  knob.name = "bounces";
  knob.text =
      "Scatterings that a pulse's light may have; of a camera's light, surfaces after the first that it may meet.";
  knob.applies = [](const Subject& s) {
    return s.lidar != nullptr || (s.between_surfaces && !s.simulation.atmosphere.none);
  };
  knob.levels = [](const Subject& s) {
    return s.lidar ? with_own({1, 2, 3, 4}, s.lidar->transport.max_bounces)
                   : with_own({0, 1, 2, 4, 8, 16}, s.simulation.bounces);
  };
  knob.get = [](const Subject& s) {
    return static_cast<double>(s.lidar ? s.lidar->transport.max_bounces : s.simulation.bounces);
  };
  knob.set = [](const Subject& s, double level) {
    (s.lidar ? s.lidar->transport.max_bounces : s.simulation.bounces) = static_cast<int>(std::lround(level));
  };
  knob.label = whole_label;
  return knob;
}

}  // namespace raycube::knobs
