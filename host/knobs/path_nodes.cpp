#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_path_nodes() {
  Knob knob;
  knob.name = "path_nodes";
  knob.text = "Nodes of path radiance along each of its two axes of direction, linear between.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr && !s.simulation.atmosphere.none; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.simulation.plan.path_nodes); };
  knob.levels = node_levels;
  knob.set = [](const Subject& s, double level) {
    s.simulation.plan.path_nodes = static_cast<int>(std::lround(level));
  };
  knob.label = plan_label;
  return knob;
}

}  // namespace raycube::knobs
