// Filling a render table: axes and rows by the names, units and axes of the registry, values sized and zero until
// filled.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/render_table.h"

namespace raycube::atmos {

/// Adds the axis under its registered unit. Throws Error(bug) on an unregistered name.
Axis& add_axis(RenderTable& table, const std::string& name, std::vector<double> nodes);

/// Adds the row over its registered axes (which the table must hold), every value 0, to be filled by the caller.
/// text: what the values are and where they come from. Throws Error(bug) on an unregistered name.
Row& add_row(RenderTable& table, const std::string& name, const std::string& text);

/// Number of values a row over these axes holds.
std::size_t row_size(const RenderTable& table, const std::vector<std::string>& axes);

/// Every rule of the format: registered names, units and axes; nodes finite, strictly ascending, inside their limits;
/// value count; values finite and inside their limits; k weights sum to 1; depth and transmission rows agree. Reports
/// all that is broken as one Error(input); `file` names the table in the messages.
void validate(const RenderTable& table, const std::string& file);

}  // namespace raycube::atmos
