// The points of a sweep and what they gave.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/experiment/sweep_file.h"

namespace raycube::experiment {

/// Values of the parameters at each point, in the method's order.
std::vector<std::vector<double>> points_of(const Sweep& sweep);

/// Metrics of each point: steps that are kept are not run again, and points that share a step share its folder. told:
/// after each point. Throws Error that names the point.
std::vector<std::vector<double>> run_points(const Sweep& sweep, const std::vector<std::vector<double>>& points,
                                            KeptSteps& steps, const std::function<void()>& told);

/// The table, a row a point.
std::string sweep_csv(const Sweep& sweep, const std::vector<std::vector<double>>& points,
                      const std::vector<std::vector<double>>& metrics);

/// Table and indices (sobol: first order and total with intervals; one at a time: spans from the point at rest).
nlohmann::ordered_json sweep_json(const Sweep& sweep, const std::vector<std::vector<double>>& points,
                                  const std::vector<std::vector<double>>& metrics);

}  // namespace raycube::experiment
