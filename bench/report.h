// Figures of a benchmark run: flat keys with unit, spread and goal, as a table and as build/bench.json.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace raycube::bench {

/// Median of repeated measurements with their extremes.
struct Spread {
  double median = 0, lowest = 0, highest = 0;
  int count = 0;
};

Spread spread_of(std::vector<double> values);

/// What a figure must reach. A guard that fails makes the run fail: its figures mean nothing then.
struct Goal {
  enum class Sense { at_least, at_most } sense = Sense::at_least;
  double value = 0;
  bool guard = false;
  static Goal at_least(double value) { return {Sense::at_least, value, false}; }
  static Goal at_most(double value) { return {Sense::at_most, value, false}; }
  Goal as_guard() const { return {sense, value, true}; }
  bool met(double figure) const { return sense == Sense::at_least ? figure >= value : figure <= value; }
};

/// SHA-256 of the source and options of programs that were launched; empty: not launched.
struct Programs {
  std::string all, trace;
};

class Report {
 public:
  /// What was measured on; `commit` as given by ci/bench.
  explicit Report(const std::string& commit);

  void set_text(const std::string& key, const std::string& value);
  void add(const std::string& key, double value, const std::string& unit, std::optional<Goal> goal = {});
  void add(const std::string& key, const Spread& spread, const std::string& unit, std::optional<Goal> goal = {});

  /// A check that must hold before anything is timed; prints what was found. Throws Error(check) when it does not.
  void validate(const std::string& what, double found, double limit);

  /// The park's programs. All who launch them must name the same: throws Error(check) when two differ.
  void add_programs(const std::string& launcher, const Programs& programs);

  /// Figures, texts, and which goals were missed.
  void print_table() const;
  /// Flat keys; a spread adds KEY_min, KEY_max and KEY_runs, a goal KEY_goal and KEY_goal_is. Written under a temporary
  /// name, then renamed.
  void write_json(const std::string& path) const;
  bool guards_hold() const;
  /// "key found of goal" of each goal missed.
  std::vector<std::string> missed() const;

 private:
  struct Figure {
    std::string key, unit;
    Spread spread;
    std::optional<Goal> goal;
  };
  std::vector<std::pair<std::string, std::string>> texts_;
  std::vector<Figure> figures_;
  std::map<std::string, std::pair<std::string, std::string>> programs_;  ///< key: hash and who launched it first
};

}  // namespace raycube::bench
