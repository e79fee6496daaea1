// What make_plan weighed on its way to a plan: each block's levels with their estimated errors. The counts that were
// chosen stand in the plan itself; users read fields, and a file gets plan_json().
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::plan {

struct Plan;

/// A sky of so many components. Errors that are not finite were not to be had.
struct SkyLevelReport {
  int components = 0;
  double error = 0;           ///< worst band: the largest change that an obstacle can see, over typical radiance
  double obstacle_error = 0;  ///< the same over the band's irradiance by the sky
  bool negative = false;      ///< refused: it drives some band's sky below zero
};

/// Error of each axis with each count of its nodes.
struct AxisErrors {
  std::vector<int> counts;
  std::vector<double> source_height, source_view, path_height, path_x, path_y;  ///< [of counts]
};

/// Thermal light that is in the plan.
struct ThermalReport {
  std::vector<SkyLevelReport> sky_levels;
  std::size_t temperatures = 0;         ///< distinct ones in the scene
  double sun_share = 0, sky_share = 0;  ///< largest share of sun and sky in any band, beside thermal light
  bool sky_left_out = false;            ///< too dark to be a source
  double temperature_nodes_error = 0;   ///< of the nodes of temperature
  double left_out_error = 0;            ///< of leaving out a dark sun and sky
};

/// Thermal light that is too dark to be in it.
struct ThermalLeftOut {
  double share = 0;      ///< at most, of a band's typical radiance
  std::size_t band = 0;  ///< where, from 0
  std::string from;      ///< what shines so
};

/// How many surfaces light comes by, where the file leaves it open.
struct BounceReport {
  bool open = false;                   ///< a look is to choose it: those planned are the most
  bool chosen = false;                 ///< by a look (host/planner/bounce_choice.h)
  double missed = 0, once_missed = 0;  ///< by those chosen; by light scattered once: of what is seen, worst band
};

struct PlanReport {
  double budget = 0;                                       ///< what nodes and components may spend of the tolerance
  std::size_t table_nodes = 0;                             ///< wavelengths of the table under the spectral grid
  double source_error = 0, path_error = 0, sky_error = 0;  ///< of nodes; of the sky's components
  double total_error = 0;                                  ///< with those of thermal light
  bool within_tolerance = true;                            ///< total_error
  scene::PlanOverrides given;                              ///< what the file asked for
  std::vector<SkyLevelReport> sky_levels;
  double irradiance_map_error = 0;
  std::optional<double> diffuse_irradiance_row_difference;  ///< of the table's row of flux and its sky's sum
  std::vector<std::pair<std::string, double>> mean_ground;  ///< material, area share of the scene's mean
  AxisErrors axes;
  BounceReport bounces;
  std::optional<ThermalReport> thermal;
  std::optional<ThermalLeftOut> thermal_left_out;
};

/// The plan and its report for a file: what was chosen, each block's estimated error.
nlohmann::json plan_json(const Plan& plan);

/// Overrides that are given and their values, by name.
std::vector<std::pair<std::string, int>> given_overrides(const scene::PlanOverrides& given);

/// "off", "mean" or "local": how the ground around a place is known.
std::string ground_mode(const Plan& plan);

}  // namespace raycube::plan
