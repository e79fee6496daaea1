#include "atmos_tables/report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include <nlohmann/json.hpp>

#include "atmos_tables/interpolate.h"
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
    json axis = {{"name", spec.name}, {"unit", spec.unit}, {"count", nodes.size()}, {"first", nodes.front()}, {"last", nodes.back()}};
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
    out["rows"].push_back({{"name", row.name}, {"unit", row.unit}, {"axes", row.axes}, {"shape", shape},
                           {"least", *low}, {"most", *high}, {"text", row.text}});
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

std::string table_json(const RenderTable& table, const std::string& hash) { return summary(table, hash).dump(2) + "\n"; }

std::string table_text(const RenderTable& table, const std::string& hash) {
  const json s = summary(table, hash);
  std::ostringstream out;
  out << "render table, content " << hash.substr(0, 16) << "\n"
      << "sun zenith " << rounded(table.sun_zenith_deg) << " deg, azimuth " << rounded(table.sun_azimuth_deg)
      << " deg; sensor at " << rounded(table.sensor_height_m) << " m above the scene's z = 0\n"
      << "wavelengths in " << table.medium << "; sun: " << table.solar_source << "\n\naxes\n";
  for (const auto& axis : s["axes"]) {
    out << "  " << padded(axis["name"], 17) << padded(std::to_string(axis["count"].get<std::size_t>()) + " nodes", 11)
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
    for (const auto& length : row["shape"]) shape += (shape.empty() ? "" : " x ") + std::to_string(length.get<std::size_t>());
    out << "  " << padded(row["name"], 25) << padded(shape, 19)
        << padded(rounded(row["least"]) + " to " + rounded(row["most"]) + " " + row["unit"].get<std::string>(), 40)
        << row["text"].get<std::string>() << "\n";
  }
  out << "\nabsent rows\n ";
  for (const auto& name : s["absent_rows"]) out << " " << name.get<std::string>();
  out << "\n\nprovenance\n" << s["provenance"].dump(2) << "\n";
  return out.str();
}

std::string plot_json(const RenderTable& table, const PlotChoice& choice, const std::string& title) {
  const double h = choice.target_height_m, view = choice.view_zenith_deg;
  json out;
  out["title"] = title;
  out["sun_zenith_deg"] = table.sun_zenith_deg;
  out["sensor_height_m"] = table.sensor_height_m;
  out["target_height_m"] = h;
  out["view_zenith_deg"] = view;
  out["relative_azimuth_deg"] = choice.relative_azimuth_deg;
  out["wavelength_um"] = wavelengths(table);
  if (table.has("solar_irradiance")) out["solar_irradiance"] = solar_irradiance(table);
  const bool sun = table.has("sun_transmission") || table.has("sun_optical_depth");
  const bool path = table.has("view_transmission") || table.has("view_optical_depth");
  if (sun) out["sun_transmission"] = sun_transmission(table, h);
  if (path) out["view_transmission"] = view_transmission(table, h, view);
  if (sun && path && table.has("two_way_factor")) out["two_way_transmission"] = two_way_transmission(table, h, view);
  if (table.has("direct_irradiance")) out["direct_irradiance"] = direct_irradiance(table, h);
  if (table.has("diffuse_irradiance")) out["diffuse_irradiance"] = diffuse_irradiance(table, h);
  if (table.has("path_radiance_solar"))
    out["path_radiance"] = path_radiance(table, h, view, choice.relative_azimuth_deg);
  if (table.has("sky_radiance_solar")) {
    const auto& l = wavelengths(table);
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < l.size(); ++i)
      if (std::abs(l[i] - choice.sky_wavelength_um) < std::abs(l[nearest] - choice.sky_wavelength_um)) nearest = i;
    // One wavelength is enough for the map: a table of that wavelength reads the same and takes no time.
    RenderTable one = table;
    one.axes.at("wavelength").nodes = {l[nearest]};
    for (auto& [name, row] : one.rows) {
      if (row.axes.empty() || row.axes.front() != "wavelength") continue;
      const std::size_t inner = row.values.size() / l.size();
      row.values = std::vector<float>(row.values.begin() + static_cast<std::ptrdiff_t>(nearest * inner),
                                      row.values.begin() + static_cast<std::ptrdiff_t>((nearest + 1) * inner));
    }
    json zenith = json::array(), azimuth = json::array(), map = json::array();
    for (int a = 0; a <= 180; a += 3) azimuth.push_back(a);
    for (int z = 0; z <= 90; z += 3) {
      zenith.push_back(z);
      json ring = json::array();
      for (int a = 0; a <= 180; a += 3) ring.push_back(sky_radiance(one, h, z, a)[0]);
      map.push_back(ring);
    }
    out["sky"] = {{"wavelength_um", l[nearest]}, {"zenith_deg", zenith}, {"azimuth_deg", azimuth}, {"radiance", map}};
  }
  return out.dump();
}

}  // namespace raycube::atmos
