#include "host/knobs/knob.h"

namespace raycube::knobs {

/// Levels are scene::SamplerKind's values; all cost the same rays, the plain grid saves its random numbers.
Knob knob_sampler() {
  Knob knob;
  knob.name = "sampler";
  knob.text =
      "How a pixel's samples lie: on a grid, on a lattice shifted in each pixel, or one at random in each cell.";
  knob.applies = [](const Subject& s) { return s.instrument != nullptr; };
  knob.get = [](const Subject& s) { return static_cast<double>(s.instrument->sampler); };
  knob.levels = [](const Subject& s) {  // a lattice has no cells to weigh by a point spread
    const bool box = s.instrument->box_pixels();
    return box ? std::vector<double>{0, 1, 2} : std::vector<double>{0, 2};
  };
  knob.set = [](const Subject& s, double level) {
    s.instrument->sampler = static_cast<scene::SamplerKind>(static_cast<int>(level));
  };
  knob.label = [](double level) { return std::string(level == 0 ? "grid" : level == 1 ? "lattice" : "jittered"); };
  return knob;
}

}  // namespace raycube::knobs
