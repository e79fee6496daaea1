#include "host/knobs/knob.h"

#include <algorithm>
#include <cmath>

#include "host/base/error.h"

namespace raycube::knobs {

#define RC_KNOB(name) Knob knob_##name();
#include "host/knobs/knobs.def"
#undef RC_KNOB

const std::vector<Knob>& all_knobs() {
  static const std::vector<Knob> knobs = {
#define RC_KNOB(name) knob_##name(),
#include "host/knobs/knobs.def"
#undef RC_KNOB
  };
  return knobs;
}

const Knob& find_knob(const std::string& name) {
  std::string known;
  for (const Knob& knob : all_knobs()) {
    if (knob.name == name) return knob;
    known += (known.empty() ? "" : ", ") + knob.name;
  }
  throw base::Error(base::Fault::input, "no knob is called '" + name + "'; there are: " + known);
}

Settings::Settings(const Subject& subject)
    : subject_(subject),
      sky_directions_(subject.simulation.sky_directions),
      bounces_(subject.simulation.bounces),
      bounces_given_(subject.simulation.bounces_given),
      plan_(subject.simulation.plan),
      adjacency_(subject.simulation.atmosphere.adjacency),
      instrument_(subject.instrument ? *subject.instrument : scene::Instrument{}),
      lidar_(subject.lidar ? *subject.lidar : scene::Lidar{}) {}

Settings::~Settings() { restore(); }

void Settings::restore() {
  subject_.simulation.sky_directions = sky_directions_, subject_.simulation.bounces = bounces_;
  subject_.simulation.bounces_given = bounces_given_;
  subject_.simulation.plan = plan_;
  subject_.simulation.atmosphere.adjacency = adjacency_;
  if (subject_.instrument) *subject_.instrument = instrument_;
  if (subject_.lidar) *subject_.lidar = lidar_;
}

std::string whole_label(double level) { return std::to_string(std::lround(level)); }
std::string plan_label(double level) { return level == 0 ? "planner" : whole_label(level); }
std::string switch_label(double level) { return level == 0 ? "off" : "on"; }

std::vector<double> with_own(std::vector<double> levels, double own) {
  if (std::find(levels.begin(), levels.end(), own) == levels.end()) levels.push_back(own);
  std::sort(levels.begin(), levels.end());
  return levels;
}

std::vector<double> node_levels(const Subject&) { return {0, 1, 2, 3, 4, 5, 7}; }

}  // namespace raycube::knobs
