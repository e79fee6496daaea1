#include "atmos_tables/report.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include <nlohmann/json.hpp>

#include "host/base/text.h"
#include "atmos_tables/row_registry.h"

namespace raycube::atmos {

namespace {

using nlohmann::json;

json summary(const RenderTable& table, const std::string& hash) {
  json out;
  out["content_hash"] = hash;
  out["version"] = table.version;
  out["medium"] = table.medium;
  out["solar_source"] = table.solar_source;
  out["sun_zenith_deg"] = table.sun_zenith_deg;
  out["sun_azimuth_deg"] = table.sun_azimuth_deg;
  out["sensor_height_m"] = table.sensor_height_m;
  out["provenance"] = table.provenance_json.empty() ? json() : json::parse(table.provenance_json);
  out["axes"] = json::array();
  for (const AxisSpec& spec : axis_registry()) {
    const auto found = table.axes.find(spec.name);
    if (found == table.axes.end()) continue;
    const auto& nodes = found->second.nodes;
    json axis = {{"name", spec.name},
                 {"unit", spec.unit},
                 {"count", nodes.size()},
                 {"first", nodes.front()},
                 {"last", nodes.back()}};
    if (nodes.size() > 1) {
      double least = std::numeric_limits<double>::max(), most = 0;
      for (std::size_t i = 1; i < nodes.size(); ++i)
        least = std::min(least, nodes[i] - nodes[i - 1]), most = std::max(most, nodes[i] - nodes[i - 1]);
      axis["least_step"] = least, axis["greatest_step"] = most;
    }
    out["axes"].push_back(axis);
  }
  out["rows"] = json::array();
  out["absent_rows"] = json::array();
  for (const RowSpec& spec : row_registry()) {
    const auto found = table.rows.find(spec.name);
    if (found == table.rows.end()) {
      out["absent_rows"].push_back(spec.name);
      continue;
    }
    const Row& row = found->second;
    json shape = json::array();
    for (const auto& axis : row.axes) shape.push_back(table.axis(axis).nodes.size());
    const auto [low, high] = std::minmax_element(row.values.begin(), row.values.end());
    out["rows"].push_back({{"name", row.name},
                           {"unit", row.unit},
                           {"axes", row.axes},
                           {"shape", shape},
                           {"least", *low},
                           {"most", *high},
                           {"text", row.text}});
  }
  return out;
}

std::string rounded(double value) {
  std::ostringstream out;
  out.precision(6);
  out << value;
  return out.str();
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text + "  ";
}

}  // namespace

std::string table_json(const RenderTable& table, const std::string& hash) {
  return summary(table, hash).dump(2) + "\n";
}

std::string table_text(const RenderTable& table, const std::string& hash) {
  const json s = summary(table, hash);
  std::ostringstream out;
  out << "render table, content " << hash.substr(0, 16) << "\n"
      << "sun zenith " << rounded(table.sun_zenith_deg) << " deg, azimuth " << rounded(table.sun_azimuth_deg)
      << " deg; sensor at " << rounded(table.sensor_height_m) << " m above the scene's z = 0\n"
      << "wavelengths in " << table.medium << "; sun: " << table.solar_source << "\n\naxes\n";
  for (const auto& axis : s["axes"]) {
    out << "  " << padded(axis["name"], 17) << padded(base::counted(axis["count"].get<std::size_t>(), "node"), 11)
        << rounded(axis["first"]) << " to " << rounded(axis["last"]) << " " << axis["unit"].get<std::string>();
    if (axis.contains("least_step"))
      out << ", steps " << rounded(axis["least_step"]) << " to " << rounded(axis["greatest_step"]);
    else
      out << ": nothing varies along it";
    out << "\n";
  }
  out << "\nrows\n";
  for (const auto& row : s["rows"]) {
    std::string shape;
    for (const auto& length : row["shape"])
      shape += (shape.empty() ? "" : " x ") + std::to_string(length.get<std::size_t>());
    out << "  " << padded(row["name"], 25) << padded(shape, 19)
        << padded(rounded(row["least"]) + " to " + rounded(row["most"]) + " " + row["unit"].get<std::string>(), 40)
        << row["text"].get<std::string>() << "\n";
  }
  out << "\nabsent rows\n ";
  for (const auto& name : s["absent_rows"]) out << " " << name.get<std::string>();
  out << "\n\nprovenance\n" << s["provenance"].dump(2) << "\n";
  return out.str();
}

}  // namespace raycube::atmos
