#include "host/knobs/knob.h"

namespace raycube::knobs {

Knob knob_overlap() {
  Knob knob;
  knob.name = "overlap";
  knob.text = "Share of the pupil that sees each point: always 1, or exact.";
  knob.applies = [](const Subject& s) { return s.lidar != nullptr; };
  knob.get = [](const Subject& s) { return s.lidar->transport.overlap == scene::LidarOverlap::off ? 0.0 : 1.0; };
  knob.levels = [](const Subject&) { return std::vector<double>{0, 1}; };
  knob.set = [](const Subject& s, double level) {
    s.lidar->transport.overlap = level == 0 ? scene::LidarOverlap::off : scene::LidarOverlap::exact;
  };
  knob.label = [](double level) { return std::string(level == 0 ? "off" : "exact"); };
  return knob;
}

}  // namespace raycube::knobs
