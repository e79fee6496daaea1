// The planner's table: block, level, estimated errors, cost, why; as lines, text and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/planner/planner.h"

namespace raycube::planner {

/// The lines of a plan, in the order in which light meets the blocks: sun, sky, air, ground, sensor.
std::vector<PlanLine> plan_lines(const Decision& decision, const plan::Plan& plan);

/// The decision and its lines, for a file.
nlohmann::json decision_json(const Decision& decision, const std::vector<PlanLine>& lines);

/// The lines, for a file.
nlohmann::json lines_json(const std::vector<PlanLine>& lines);

/// A table of fixed width, a line a block.
std::string lines_text(const std::vector<PlanLine>& lines);

/// What an image will miss of its small objects, and the way out.
std::string missed_objects_text(const sensors::SmallObjectSurvey& survey, const scene::Instrument& instrument);

/// "0.42 %", "1e-05 %"; "-" below 0.
std::string percent_text(double error);
/// The errors of samples and sky directions, or of both together where they are not known apart.
std::string drawn_text(const Decision& decision);
/// Samples of a pixel as they are taken: "lattice 34", "4 x lattice 13".
std::string sampling_text(const Sampling& sampling);

}  // namespace raycube::planner
