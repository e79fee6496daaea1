// A knob: one setting that trades accuracy for time, with its levels. `raycube chart` sweeps them, the planner picks
// among them. To add one: write host/knobs/NAME.cpp with
//     Knob raycube::knobs::knob_NAME();
// and one line RC_KNOB(NAME) in knobs.def.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::knobs {

/// What knobs turn: a simulation and one of its instruments or LIDARs; the other is null. A knob changes it in place (a
/// scene may be gigabytes, so nobody copies a simulation): see Settings.
struct Subject {
  scene::Simulation& simulation;
  scene::Instrument* instrument = nullptr;
  scene::Lidar* lidar = nullptr;
  bool between_surfaces = false;  ///< of a camera: light between surfaces is asked for by file or knob
};

/// A level is a number: a count, a width, or the place of a choice in a list; label() writes it.
struct Knob {
  std::string name;                           ///< as on the command line and in files
  std::string unit;                           ///< of the levels; empty: a count or a choice
  std::string text;                           ///< one sentence
  bool (*applies)(const Subject&) = nullptr;  ///< false: it changes nothing of this subject
  /// Cheapest first, the subject's own among them; where 0 leaves the choice to the plan it comes first.
  std::vector<double> (*levels)(const Subject&) = nullptr;
  double (*get)(const Subject&) = nullptr;
  void (*set)(const Subject&, double level) = nullptr;
  std::string (*label)(double level) = nullptr;
};

/// In the order of knobs.def.
const std::vector<Knob>& all_knobs();
/// Throws Error(input) that lists the knobs there are.
const Knob& find_knob(const std::string& name);

/// Keeps what knobs may change of a subject and puts it back when it goes.
class Settings {
 public:
  explicit Settings(const Subject& subject);
  ~Settings();
  Settings(const Settings&) = delete;
  Settings& operator=(const Settings&) = delete;
  void restore();

 private:
  Subject subject_;
  int sky_directions_, bounces_;
  bool bounces_given_;
  scene::PlanOverrides plan_;
  scene::Adjacency adjacency_;
  scene::Instrument instrument_;
  scene::Lidar lidar_;
};

// For the files of knobs.
std::string whole_label(double level);   ///< "16"
std::string plan_label(double level);    ///< the same; 0: "planner"
std::string switch_label(double level);  ///< "off", "on"
/// Ascending, `own` put in where it is missing.
std::vector<double> with_own(std::vector<double> levels, double own);
std::vector<double> node_levels(const Subject&);  ///< 0 and kNodeCounts of the plan

/// A count of the plan that 0 leaves to the planner; it means something where a camera looks through air.
template <int scene::PlanOverrides::*kCount>
Knob plan_knob(const char* name, const char* text, std::vector<double> (*levels)(const Subject&)) {
  return {name,
          "",
          text,
          [](const Subject& s) { return s.instrument != nullptr && !s.simulation.atmosphere.none; },
          levels,
          [](const Subject& s) { return static_cast<double>(s.simulation.plan.*kCount); },
          [](const Subject& s, double level) { s.simulation.plan.*kCount = static_cast<int>(std::lround(level)); },
          plan_label};
}

/// A count of a LIDAR's transport of light.
template <int scene::LidarTransport::*kCount>
Knob transport_knob(const char* name, const char* text, std::vector<double> (*levels)(const Subject&)) {
  return {name,
          "",
          text,
          [](const Subject& s) { return s.lidar != nullptr; },
          levels,
          [](const Subject& s) { return static_cast<double>(s.lidar->transport.*kCount); },
          [](const Subject& s, double level) { s.lidar->transport.*kCount = static_cast<int>(std::lround(level)); },
          whole_label};
}

}  // namespace raycube::knobs
