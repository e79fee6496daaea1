// A plan as a file that a later render replays: what was chosen for each instrument and LIDAR of one simulation.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/planner/planner.h"
#include "host/planner/lidar_trial.h"

namespace raycube::planner {

struct PlanFile {
  struct Entry {
    std::string name;
    bool lidar = false;
    Sampling sampling;        ///< of an instrument
    int subrays = 0;          ///< of a LIDAR
    nlohmann::json axes;      ///< nodes and components that make_plan chose: what a replay must find again
    nlohmann::json decision;  ///< the whole decision with its lines
  };
  std::string simulation_file, scene_hash;
  double tolerance = 0;
  scene::ToleranceMeasure tolerance_of;
  std::uint64_t seed = 0;
  std::vector<Entry> entries;
};

/// Nodes and components of a plan, as a file keeps them.
nlohmann::json axes_json(const plan::Plan& plan);

std::string write_plan_file(const PlanFile& file);
/// Throws Error(input) with the place and the way out when the file is not a plan of this program.
PlanFile read_plan_file(const std::string& path);

/// What the plan was made for and the simulation is not (scene, tolerance and what it is of, seed), each as a phrase;
/// empty: nothing.
std::vector<std::string> changes_since(const PlanFile& file, const scene::Simulation& simulation);

/// The entry of that name. Throws Error(input) that lists the names there are.
const PlanFile::Entry& find_entry(const PlanFile& file, const std::string& name, bool lidar, const std::string& path);

/// The decision that a file holds, for apply(). Where something has changed since (changes_since, or nodes and
/// components that are not the file's) its settings are a first guess: what the trial found is left out, as of settings
/// that a simulation gives, and a note says what has changed. Throws Error(input) where the simulation itself gives
/// samples or directions that are not the plan's.
Decision replayed(const PlanFile::Entry& entry, std::vector<std::string> changes, const scene::Simulation& simulation,
                  const scene::Instrument& instrument, const plan::Plan& plan, const std::string& path);

/// The same of a LIDAR.
LidarDecision replayed(const PlanFile::Entry& entry, const std::vector<std::string>& changes,
                       const lidar::LidarPlan& plan, double tolerance, const std::string& path);

}  // namespace raycube::planner
