#include "atmos_tables/import/imported.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <tuple>

#include "host/base/text.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

bool at_most_one(const Column& column) {
  return column.unit == "1" && (column.name.find("transmi") != std::string::npos || column.name == "spherical_albedo" ||
                                column.name == "surface_emissivity");
}

}  // namespace

const Column* Run::find(const std::string& name) const {
  for (const auto& column : columns)
    if (column.name == name) return &column;
  return nullptr;
}

const Column& Run::at(const std::string& name) const {
  if (const Column* column = find(name)) return *column;
  std::string names;
  for (const auto& column : columns) names += (names.empty() ? "" : ", ") + column.name;
  throw base::Error(base::Fault::input, "no column " + name + " was imported (there are: " + names + ")");
}

void check_run(const Run& run, const base::Where& where, base::Problems& problems, double slack) {
  if (run.wavelength_um.empty()) problems.add(where, "no data rows", "", "is the file whole?");
  std::set<std::tuple<std::string, double, bool, double, double, int>> seen;
  for (const auto& column : run.columns) {
    base::Where here = where;
    here.element = column.source;
    const Place& p = column.place;
    if (!seen.insert({column.name, p.height_m.value_or(-1e9), p.top_of_air, p.zenith_deg.value_or(-1),
                      p.relative_azimuth_deg.value_or(-1), p.k.value_or(0)})
             .second)
      problems.add(here, "two columns mean " + column.name, "", "is the header whole?");
    if (column.values.size() != run.wavelength_um.size() || column.rounding.size() != column.values.size()) {
      problems.add(
          here, "the column is not as long as the axis",
          base::counted(column.values.size(), "value") + ", " + base::counted(run.wavelength_um.size(), "wavelength"),
          "");
      continue;
    }
    const double most = at_most_one(column) ? 1 + slack : HUGE_VAL;
    for (std::size_t i = 0; i < column.values.size(); ++i) {
      const double value = column.values[i];
      const std::string place = " at " + shown(run.wavelength_um[i]) + " um";
      if (!std::isfinite(value))
        problems.add(here, "a value is not finite" + place, shown(value), "run the code anew");
      else if (value < 0)
        problems.add(here, "a value is negative" + place, shown(value), "run the code anew");
      else if (value > most + column.rounding[i])
        problems.add(here, "a value is above 1" + place, shown(value), "run the code anew");
      else
        continue;
      break;  // one message per column says it
    }
  }
}

void sort_ascending(Run& run) {
  if (run.wavelength_um.size() < 2 || run.wavelength_um.front() < run.wavelength_um.back()) return;
  std::reverse(run.wavelength_um.begin(), run.wavelength_um.end());
  for (auto& column : run.columns) {
    std::reverse(column.values.begin(), column.values.end());
    std::reverse(column.rounding.begin(), column.rounding.end());
  }
}

}  // namespace raycube::atmos::imported
