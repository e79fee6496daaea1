#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

/// Points of the first pass; 0: none. Levels that are not fewer than the samples change nothing.
Knob knob_adaptive() {
  Knob knob;
  knob.name = "adaptive";
  knob.text = "First pass of so many samples; pixels that it settles keep it, the others get all.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr && s.instrument->box_pixels(); };
  knob.get = [](const Subject& s) { return static_cast<double>(s.instrument->first_samples); };
  knob.levels = [](const Subject& s) { return with_own({0, 8, 16, 32, 64}, s.instrument->first_samples); };
  knob.set = [](const Subject& s, double level) { s.instrument->first_samples = static_cast<int>(std::lround(level)); };
  knob.label = [](double level) { return level == 0 ? std::string("off") : "first " + whole_label(level); };
  return knob;
}

}  // namespace raycube::knobs
