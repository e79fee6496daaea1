#include "atmos_tables/render_table.h"

#include "host/base/error.h"

namespace raycube::atmos {

const Row& RenderTable::need(const std::string& row, const std::string& needed_by) const {
  const auto found = rows.find(row);
  if (found == rows.end())
    throw base::Error(base::Fault::input,
                      "atmosphere table has no row '" + row + "', which " + needed_by +
                          " needs; build or import a table that holds it (raycube atmos info lists rows)");
  return found->second;
}

const Axis& RenderTable::axis(const std::string& name) const {
  const auto found = axes.find(name);
  if (found == axes.end()) throw base::Error(base::Fault::input, "atmosphere table has no axis '" + name + "'");
  return found->second;
}

}  // namespace raycube::atmos
