// Every row and axis a render table can hold: the one list behind validation, `raycube atmos info` and
// docs/table_format.md. A table may lack any row; it may hold no other.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace raycube::atmos {

struct AxisSpec {
  const char* name;
  const char* unit;
  double min, max;  ///< inclusive limits of a node
  const char* text;
};

struct RowSpec {
  const char* name;
  const char* unit;
  const char* axes;  ///< space-separated, in storage order (last fastest); [k] may be there or not
  double min, max;   ///< inclusive limits of a value
  const char* text;
};

const std::vector<AxisSpec>& axis_registry();
const std::vector<RowSpec>& row_registry();
/// nullptr when unknown.
const AxisSpec* find_axis_spec(std::string_view name);
const RowSpec* find_row_spec(std::string_view name);

/// The two tables as Markdown, as docs/table_format.md holds them.
std::string registry_markdown();

}  // namespace raycube::atmos
