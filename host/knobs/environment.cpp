#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_environment() {
  Knob knob;
  knob.name = "environment";
  knob.text =
      "Light that the air scatters in from the ground around: none, of the scene's mean ground, or of the ground near "
      "each place.";
  knob.applies = [](const Subject& s) {
    const scene::AtmosphereSpec& air = s.simulation.atmosphere;
    return s.instrument != nullptr && !air.none && (air.layered || !air.table_file.empty());
  };
  knob.get = [](const Subject& s) {
    const scene::Adjacency now = s.simulation.atmosphere.adjacency;
    return now == scene::Adjacency::off ? 0.0 : now == scene::Adjacency::mean ? 1.0 : 2.0;
  };
  knob.levels = [](const Subject&) { return std::vector<double>{0, 1, 2}; };
  // The highest is left to the table: one without the rows has nothing to couple.
  knob.set = [](const Subject& s, double level) {
    s.simulation.atmosphere.adjacency = level == 0   ? scene::Adjacency::off
                                        : level == 1 ? scene::Adjacency::mean
                                                     : scene::Adjacency::automatic;
  };
  knob.label = [](double level) { return std::string(level == 0 ? "off" : level == 1 ? "mean" : "local"); };
  return knob;
}

}  // namespace raycube::knobs
