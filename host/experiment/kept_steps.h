// Steps whose results are kept: a folder each, with a record of what made it. A step is not run again while nothing
// that it is made of has changed: its commands, the files they name, other inputs, the steps it builds on, the program.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host/experiment/commands.h"

namespace raycube::experiment {

struct StepPlan {
  std::string name;
  std::vector<Command> commands;    ///< with names in braces: {folder} is the step's own, {STEP} another's, {here}
  std::vector<std::string> inputs;  ///< files and folders they read besides those they name
  std::string where;                ///< for messages
  std::string more;                 ///< what it is made of besides
};

struct KeptStep {
  std::string folder, key;
  double seconds = 0, processor_s = 0;
  bool run = false;  ///< now; false: it was there
};

class KeptSteps {
 public:
  /// `folder`: of the study's results, made where missing; one that holds anything else is refused (Error input), and
  /// so is a second run at the same time. here: the study's own folder, in which commands run. looks_only: makes
  /// nothing.
  /// study: whose they are, a file's path; another's are refused.
  KeptSteps(const std::string& folder, const std::string& here, const std::string& study, bool looks_only = false);
  ~KeptSteps();
  KeptSteps(const KeptSteps&) = delete;
  KeptSteps& operator=(const KeptSteps&) = delete;

  /// Whether the step is there as it would be made now. names: values besides folders of steps.
  bool is_kept(const StepPlan& step, const Names& names = {}) const;
  /// Runs the step unless it is kept. by_key: its folder is called after what makes it, so that many of one name are
  /// kept side by side.
  KeptStep make(const StepPlan& step, const Names& names = {}, bool by_key = false);
  /// Removes what an earlier run reported, by these files' names in the study's folder: whatever is there afterwards is
  /// of this run.
  void forget_reports(const std::vector<std::string>& names) const;
  /// Folders of the steps made so far, by name, and {here}.
  const Names& folders() const { return folders_; }
  const std::string& folder() const { return folder_; }
  /// Forgets steps made so far, as names for others; their folders stay.
  void forget(const std::string& name) { folders_.erase(name), keys_.erase(name); }

 private:
  std::string key_of(const StepPlan& step, const Names& names) const;
  /// Of the names, those that the step is made of, itself or by a step that it builds on.
  Names values_of(const StepPlan& step, const Names& names) const;
  std::string file_hash(const std::string& path) const;
  std::string folder_of(const StepPlan& step, const std::string& key, bool by_key) const;

  std::string folder_, here_, program_;
  int lock_ = -1;
  Names folders_;
  std::map<std::string, std::string> keys_;
  std::map<std::string, Names> values_;
  mutable std::map<std::string, std::pair<std::string, std::string>> hashes_;  ///< path: size and time, hash
};

}  // namespace raycube::experiment
