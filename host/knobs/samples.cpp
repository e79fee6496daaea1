#include <cmath>

#include "host/knobs/knob.h"

namespace raycube::knobs {

/// n of an n x n grid; of another grid the root of its samples, which set() makes square.
Knob knob_samples() {
  Knob knob;
  knob.name = "samples";
  knob.text = "Samples of a pixel: n of an n x n grid, or of n^2 lattice points.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr; };
  knob.get = [](const Subject& s) {
    return std::sqrt(static_cast<double>(s.instrument->samples_u) * s.instrument->samples_v);
  };
  knob.levels = [](const Subject& s) {
    std::vector<double> levels = {1, 2, 3, 4, 5, 7, 9, 11, 15, 21};
    return s.instrument->samples_u == s.instrument->samples_v ? with_own(levels, s.instrument->samples_u) : levels;
  };
  knob.set = [](const Subject& s, double level) {
    s.instrument->samples_u = s.instrument->samples_v = static_cast<int>(std::lround(level));
    s.instrument->replicates = 1;
  };
  knob.label = [](double level) {
    if (level == std::round(level)) return whole_label(level) + "x" + whole_label(level);
    return whole_label(level * level) + " in all";
  };
  return knob;
}

}  // namespace raycube::knobs
