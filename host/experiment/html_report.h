// The report of an experiment: one HTML page with its pictures inside, and its numbers as JSON.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/experiment/experiment_file.h"

namespace raycube::experiment {

struct ToldValue {
  const FigureValue* value = nullptr;
  nlohmann::json found;  ///< a number, a text; null: JSON has null there
  std::string text;      ///< with its digits and unit
};

struct ToldFigure {
  const Figure* figure = nullptr;
  std::vector<std::string> pictures;  ///< paths
  std::vector<ToldValue> values;
};

/// Pictures and numbers of all figures. Throws Error(input) where a file, a picture or a place in it is not there.
std::vector<ToldFigure> told_figures(const Experiment& experiment, const Names& folders);

/// Numbers as the report has them.
nlohmann::ordered_json numbers_json(const Experiment& experiment, const std::vector<ToldFigure>& figures,
                                    const std::vector<std::pair<std::string, KeptStep>>& steps);

/// A page that needs nothing else, for screens narrow and wide, light and dark, and for paper.
std::string report_html(const Experiment& experiment, const std::vector<ToldFigure>& figures,
                        const std::vector<std::pair<std::string, KeptStep>>& steps);

}  // namespace raycube::experiment
