// Steps of a study's file, and the names in braces that its texts may use.
#pragma once

#include <set>
#include <string>

#include "host/experiment/kept_steps.h"
#include "host/experiment/study_table.h"

namespace raycube::experiment {

/// Reports a name that no folder can have, that stands for something else (folder, here, points, results), or that is
/// known already; adds it to what is known.
void take_name(StudyTable& table, const std::string& name, std::set<std::string>& known);

/// Reports names in braces that stand for nothing. more: what stands for something besides.
void check_names(StudyTable& table, const std::string& text, const std::set<std::string>& known,
                 const std::set<std::string>& more = {"here"});

/// A [[step]], whose commands may name what is known, {folder} and {here}; its own name is known from then on.
StepPlan read_step(StudyTable& table, std::set<std::string>& known);

/// Commands and inputs of a step, from `run` and `inputs`; more: names besides those that are known.
StepPlan read_commands(StudyTable& table, const std::string& name, const std::set<std::string>& known,
                       const std::set<std::string>& more);

}  // namespace raycube::experiment
