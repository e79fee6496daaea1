#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_sky_directions() {
  Knob knob;
  knob.name = "sky_directions";
  knob.text = "Rays that a pixel sends into the sky, shared out among its samples.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr && !s.simulation.atmosphere.none; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.simulation.sky_directions); };
  knob.levels = [](const Subject& s) {
    return with_own({4, 8, 16, 32, 64, 128, 256, 512}, s.simulation.sky_directions);
  };
  knob.set = [](const Subject& s, double level) { s.simulation.sky_directions = static_cast<int>(std::lround(level)); };
  knob.label = whole_label;
  return knob;
}

}  // namespace raycube::knobs
