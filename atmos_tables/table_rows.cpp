#include "atmos_tables/table_rows.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "atmos_tables/row_registry.h"
#include "host/base/error.h"
#include "host/base/text.h"

namespace raycube::atmos {

namespace {

std::vector<std::string> split(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> out;
  for (std::string word; in >> word;) out.push_back(word);
  return out;
}

/// The registered axes of a row; with_k: the optional k is there.
std::vector<std::string> registered_axes(const RowSpec& spec, bool with_k) {
  std::vector<std::string> out;
  for (const std::string& word : split(spec.axes)) {
    if (word == "[k]") {
      if (with_k) out.push_back("k");
    } else {
      out.push_back(word);
    }
  }
  return out;
}

std::string number(double value) {
  std::ostringstream out;
  out.precision(9);
  out << value;
  return out.str();
}

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const auto& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

void check_axis(const std::string& key, const Axis& axis, const std::string& file, base::Problems& problems) {
  const AxisSpec* spec = find_axis_spec(key);
  const base::Where where{file, 0, 0, "axis " + key};
  if (!spec || axis.name != key) return problems.add(where, "unknown axis", axis.name, "see docs/table_format.md");
  if (axis.unit != spec->unit)
    problems.add(where, std::string("unit must be ") + spec->unit, axis.unit, "convert the nodes");
  if (axis.nodes.empty()) problems.add(where, "has no nodes", "0 nodes", "give at least one");
  for (std::size_t i = 0; i < axis.nodes.size(); ++i) {
    const double node = axis.nodes[i];
    const base::Where at{file, 0, 0, "axis " + key + " node " + std::to_string(i)};
    if (!(node >= spec->min && node <= spec->max))
      return problems.add(at, "must lie in " + number(spec->min) + " to " + number(spec->max) + " " + spec->unit,
                          number(node), "correct the node");
    if (i > 0 && !(node > axis.nodes[i - 1]))
      return problems.add(at, "nodes must ascend strictly", number(axis.nodes[i - 1]) + " then " + number(node),
                          "sort and remove doubles");
  }
}

void check_row(const RenderTable& table, const std::string& key, const Row& row, const std::string& file,
               base::Problems& problems) {
  const RowSpec* spec = find_row_spec(key);
  const base::Where where{file, 0, 0, "row " + key};
  if (!spec || row.name != key) return problems.add(where, "unknown row", row.name, "see docs/table_format.md");
  if (row.unit != spec->unit)
    problems.add(where, std::string("unit must be ") + spec->unit, row.unit, "convert the values");
  if (row.axes != registered_axes(*spec, false) && row.axes != registered_axes(*spec, true))
    return problems.add(where, std::string("axes must be ") + spec->axes, joined(row.axes), "reorder the values");
  for (const std::string& axis : row.axes)
    if (!table.axes.count(axis))
      return problems.add(where, "axis " + axis + " is not in the table", "", "add the axis");
  const std::size_t size = row_size(table, row.axes);
  if (row.values.size() != size)
    return problems.add(where, "needs " + base::counted(size, "value"), std::to_string(row.values.size()),
                        "check the axes");
  for (std::size_t i = 0; i < size; ++i) {
    const double value = row.values[i];
    if (value >= spec->min && value <= spec->max) continue;
    const std::string rule = std::isfinite(value) ? "must lie in " + number(spec->min) + " to " + number(spec->max)
                                                  : std::string("must be a finite number");
    return problems.add({file, 0, 0, "row " + key + " value " + std::to_string(i)}, rule, number(value),
                        "correct the source of the table");
  }
}

void check_depth_agrees(const RenderTable& table, const char* depth_name, const char* transmission_name,
                        const std::string& file, base::Problems& problems) {
  if (!table.has(depth_name) || !table.has(transmission_name)) return;
  const Row &depth = table.rows.at(depth_name), &transmission = table.rows.at(transmission_name);
  if (depth.values.size() != transmission.values.size()) return;
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const double expected = std::exp(-double(depth.values[i]));
    // Two float roundings: 6e-8 of T plus 6e-8 of the depth, with a factor of four.
    const double allowed = expected * (2.4e-7 * (1 + double(depth.values[i]))) + 1e-37;
    if (std::abs(expected - double(transmission.values[i])) <= allowed) continue;
    problems.add({file, 0, 0, std::string("row ") + transmission_name + " value " + std::to_string(i)},
                 std::string("must equal exp(-") + depth_name + ") = " + number(expected),
                 number(transmission.values[i]), "write both from one source");
    return;
  }
}

}  // namespace

std::size_t row_size(const RenderTable& table, const std::vector<std::string>& axes) {
  std::size_t size = 1;
  for (const std::string& axis : axes) size *= table.axis(axis).nodes.size();
  return size;
}

Axis& add_axis(RenderTable& table, const std::string& name, std::vector<double> nodes) {
  const AxisSpec* spec = find_axis_spec(name);
  if (!spec) throw base::Error(base::Fault::bug, "add_axis: '" + name + "' is not in the axis registry");
  return table.axes[name] = Axis{name, spec->unit, std::move(nodes)};
}

Row& add_row(RenderTable& table, const std::string& name, const std::string& text) {
  const RowSpec* spec = find_row_spec(name);
  if (!spec) throw base::Error(base::Fault::bug, "add_row: '" + name + "' is not in the row registry");
  Row row{name, spec->unit, text, registered_axes(*spec, false), {}};
  row.values.resize(row_size(table, row.axes));
  return table.rows[name] = std::move(row);
}

void validate(const RenderTable& table, const std::string& file) {
  base::Problems problems;
  const base::Where where{file, 0, 0, ""};
  if (table.medium != "vacuum" && table.medium != "air")
    problems.add(where, "medium must be vacuum or air", table.medium, "name the medium of the wavelength axis");
  if (!(table.sun_zenith_deg >= 0 && table.sun_zenith_deg <= 180))
    problems.add(where, "sun zenith must lie in 0 to 180 deg", number(table.sun_zenith_deg), "correct the angle");
  if (!(table.sun_azimuth_deg >= -360 && table.sun_azimuth_deg <= 360))
    problems.add(where, "sun azimuth must lie in -360 to 360 deg", number(table.sun_azimuth_deg), "correct the angle");
  if (!std::isfinite(table.sensor_height_m))
    problems.add(where, "sensor height must be finite", number(table.sensor_height_m),
                 "give metres above the scene's z = 0");
  if (!table.axes.count("wavelength")) problems.add(where, "has no axis 'wavelength'", "", "add the axis");
  for (const auto& [key, axis] : table.axes) check_axis(key, axis, file, problems);
  problems.throw_if_any();
  for (const auto& [key, row] : table.rows) check_row(table, key, row, file, problems);
  problems.throw_if_any();
  check_depth_agrees(table, "sun_optical_depth", "sun_transmission", file, problems);
  check_depth_agrees(table, "view_optical_depth", "view_transmission", file, problems);
  if (table.has("k_weight")) {
    const Row& weight = table.rows.at("k_weight");
    const std::size_t terms = table.axis("k").nodes.size();
    for (std::size_t i = 0; i < weight.values.size(); i += terms) {
      double sum = 0;
      for (std::size_t k = 0; k < terms; ++k) sum += weight.values[i + k];
      if (std::abs(sum - 1) < 1e-5) continue;
      problems.add({file, 0, 0, "row k_weight wavelength " + std::to_string(i / terms)}, "weights must sum to 1",
                   number(sum), "normalise them");
      break;
    }
  }
  problems.throw_if_any();
}

}  // namespace raycube::atmos
