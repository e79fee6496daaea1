// A sweep: parameters, what is run for each of their points, and the numbers that are wanted of it (docs/studies.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/experiment/kept_steps.h"

namespace raycube::experiment {

enum class SweepMethod { factorial, one_at_a_time, sobol };

struct Parameter {
  std::string name;
  std::vector<double> values;  ///< levels; of a range evenly, or evenly in the logarithm
  double from = 0, to = 0;     ///< of a range
  bool range = false, logarithmic = false;
  double rest = 0;  ///< while others change
  /// Value at a share of the way, 0 to 1.
  double at(double share) const;
};

struct Metric {
  std::string name, file, at, unit;
  double times = 1;
  std::string where;
};

struct Sweep {
  std::string folder, title, text;
  SweepMethod method = SweepMethod::one_at_a_time;
  std::uint32_t base_points = 64;
  std::vector<Parameter> parameters;
  std::vector<StepPlan> steps;
  std::optional<StepPlan> batch;  ///< instead of steps: one command for all points, from {points} to {results}
  std::vector<Metric> metrics;
};

/// Throws Error(input) with all that is wrong in it.
Sweep read_sweep(const std::string& file);

}  // namespace raycube::experiment
