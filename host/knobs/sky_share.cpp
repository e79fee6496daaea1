#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_sky_share() {
  Knob knob;
  knob.name = "sky_share";
  knob.text =
      "Each sample looks into one in so many of its pixel's sky directions; planner: by the samples that leaves to a "
      "direction.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr && !s.simulation.atmosphere.none; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.simulation.sky_share); };
  knob.levels = [](const Subject& s) {
    std::vector<double> levels;
    for (const int share : {0, 1, 2, 4, 8, 16})
      if (share == 0 || s.simulation.sky_directions % share == 0) levels.push_back(share);
    return with_own(levels, s.simulation.sky_share);
  };
  knob.set = [](const Subject& s, double level) { s.simulation.sky_share = static_cast<int>(std::lround(level)); };
  knob.label = plan_label;
  return knob;
}

}  // namespace raycube::knobs
