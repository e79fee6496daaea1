#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_sky_directions() {
  Knob knob;
  knob.name = "sky_directions";
  knob.text = "Directions in which a pixel looks for the sky.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr && !s.simulation.atmosphere.none; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.simulation.sky_directions); };
  knob.levels = [](const Subject& s) {
    std::vector<double> levels;
    for (const int k : {1, 2, 4, 8, 16, 32, 64, 128})
      if (s.simulation.sky_share == 0 || k % s.simulation.sky_share == 0) levels.push_back(k);
    return with_own(levels, s.simulation.sky_directions);
  };
  knob.set = [](const Subject& s, double level) { s.simulation.sky_directions = static_cast<int>(std::lround(level)); };
  knob.label = whole_label;
  return knob;
}

}  // namespace raycube::knobs
