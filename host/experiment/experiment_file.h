// An experiment: steps that make results, and figures that show them beside what was published (docs/studies.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/experiment/kept_steps.h"

namespace raycube::experiment {

/// A number among the results: a place in a JSON file, {step}/file.json and where in it (result_files.h).
struct FigureValue {
  std::string name, file, at, unit;
  double times = 1;
  int digits = 3;                        ///< significant
  std::optional<std::string> published;  ///< as it was printed
};

struct Figure {
  std::string of;                     ///< what it stands for: "Figure 8"; empty: nothing published
  std::string title, text, why;       ///< why it differs
  std::vector<std::string> pictures;  ///< PNG
  std::vector<FigureValue> values;
  std::string where;
};

struct Experiment {
  std::string file, folder, title, text, source;  ///< source: of what was published
  std::vector<StepPlan> steps;
  std::vector<Figure> figures;
};

/// Throws Error(input) with all that is wrong in it.
Experiment read_experiment(const std::string& file);

}  // namespace raycube::experiment
