#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_sky_rank() {
  Knob knob;
  knob.name = "sky_rank";
  knob.text = "Components of the sunlit sky.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr && !s.simulation.atmosphere.none; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.simulation.plan.sky_rank); };
  knob.levels = [](const Subject&) { return std::vector<double>{0, 1, 2, 3, 4}; };
  knob.set = [](const Subject& s, double level) { s.simulation.plan.sky_rank = static_cast<int>(std::lround(level)); };
  knob.label = plan_label;
  return knob;
}

}  // namespace raycube::knobs
