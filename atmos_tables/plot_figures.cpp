#include <algorithm>
#include <cmath>
#include <functional>

#include <nlohmann/json.hpp>

#include "atmos_tables/detail/lit_factor.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/report.h"

namespace raycube::atmos {

namespace {

using nlohmann::json;

std::size_t nearest_node(const std::vector<double>& nodes, double wanted) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < nodes.size(); ++i)
    if (std::abs(nodes[i] - wanted) < std::abs(nodes[nearest] - wanted)) nearest = i;
  return nearest;
}

/// The table of one of its wavelengths: reads the same, and takes no time.
RenderTable of_one_wavelength(const RenderTable& table, std::size_t index) {
  RenderTable one = table;
  const std::size_t count = wavelengths(table).size();
  one.axes.at("wavelength").nodes = {wavelengths(table)[index]};
  for (auto& [name, row] : one.rows) {
    if (row.axes.empty() || row.axes.front() != "wavelength") continue;
    const std::size_t inner = row.values.size() / count;
    row.values = std::vector<float>(row.values.begin() + static_cast<std::ptrdiff_t>(index * inner),
                                    row.values.begin() + static_cast<std::ptrdiff_t>((index + 1) * inner));
  }
  return one;
}

/// Where an axis can be read: from 0 to `last` when nothing varies along it.
std::pair<double, double> readable(const RenderTable& table, const char* axis, double last) {
  const auto& nodes = table.axis(axis).nodes;
  return nodes.size() == 1 ? std::pair(0.0, last) : std::pair(nodes.front(), nodes.back());
}

/// Every `step` of a range, its ends, and every half degree within 10 degrees of `centre`, where the aureole is.
std::vector<double> angles(std::pair<double, double> range, double step, double centre) {
  std::vector<double> out{range.first, range.second};
  const auto add = [&](double angle) {
    if (angle > range.first && angle < range.second) out.push_back(angle);
  };
  for (int i = 0; i * step <= 180; ++i) add(i * step);
  for (int i = -20; i <= 20; ++i) add(centre + 0.5 * i);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end(), [](double x, double y) { return y - x < 1e-6; }), out.end());
  return out;
}

json sky_map(const RenderTable& table, double h, std::size_t index) {
  const RenderTable one = of_one_wavelength(table, index);
  const auto zenith = angles(readable(table, "sky_zenith", 90), 3, table.sun_zenith_deg),
             azimuth = angles(readable(table, "sky_azimuth", 180), 3, 0);
  json map = json::array(), plane_zenith = json::array(), plane = json::array();
  for (const double z : zenith) {
    json ring = json::array();
    for (const double a : azimuth) ring.push_back(sky_radiance(one, h, z, a)[0]);
    map.push_back(ring);
  }
  // From the horizon behind, through the zenith and the sun: behind counts negative.
  for (auto z = zenith.rbegin(); z != zenith.rend() && *z > 0; ++z)
    plane_zenith.push_back(-*z), plane.push_back(sky_radiance(one, h, *z, azimuth.back())[0]);
  for (const double z : zenith) plane_zenith.push_back(z), plane.push_back(sky_radiance(one, h, z, azimuth.front())[0]);
  return {{"wavelength_um", wavelengths(table)[index]},
          {"zenith_deg", zenith},
          {"azimuth_deg", azimuth},
          {"radiance", map},
          {"plane_zenith_deg", plane_zenith},
          {"plane_radiance", plane}};
}

json thermal_sky(const RenderTable& table, double h) {
  const auto& l = wavelengths(table);
  const auto zenith = angles(readable(table, "sky_zenith", 90), 3, -100);
  json out{{"zenith_deg", zenith}, {"curves", json::array()}};
  std::vector<std::size_t> drawn;
  for (const double wanted : {4.0, 8.5, 10.0, 12.0}) {
    const std::size_t index = nearest_node(l, wanted);
    if (std::abs(l[index] - wanted) > 0.1 * wanted || std::count(drawn.begin(), drawn.end(), index)) continue;
    drawn.push_back(index);
    const RenderTable one = of_one_wavelength(table, index);
    json radiance = json::array();
    for (const double z : zenith) radiance.push_back(sky_radiance_thermal(one, h, z)[0]);
    out["curves"].push_back({{"wavelength_um", l[index]}, {"radiance", radiance}});
  }
  return out;
}

}  // namespace

std::string plot_json(const RenderTable& table, const PlotChoice& choice, const std::string& title) {
  const double h = choice.target_height_m, view = choice.view_zenith_deg, azimuth = choice.relative_azimuth_deg;
  json out;
  out["title"] = title;
  out["sun_zenith_deg"] = table.sun_zenith_deg;
  out["sensor_height_m"] = table.sensor_height_m;
  out["target_height_m"] = h;
  out["view_zenith_deg"] = view;
  out["relative_azimuth_deg"] = azimuth;
  out["wavelength_um"] = wavelengths(table);
  if (table.has("solar_irradiance")) out["solar_irradiance"] = solar_irradiance(table);
  const bool sun = table.has("sun_transmission") || table.has("sun_optical_depth");
  const bool path = table.has("view_transmission") || table.has("view_optical_depth");
  if (sun) out["sun_transmission"] = sun_transmission(table, h);
  if (path) out["view_transmission"] = view_transmission(table, h, view);
  if (sun && path && (table.has("two_way_factor") || table.has("k_weight"))) {
    out["two_way_transmission"] = two_way_transmission(table, h, view);
    out["two_way_factor"] = detail::lit_two_way_factor(table, h, view);
  }
  if (table.has("two_way_factor_thermal")) out["two_way_factor_thermal"] = two_way_factor_thermal(table, h, view);
  if (table.has("direct_irradiance")) out["direct_irradiance"] = direct_irradiance(table, h);
  if (table.has("diffuse_irradiance")) out["diffuse_irradiance"] = diffuse_irradiance(table, h);
  if (table.has("path_radiance_solar")) out["path_radiance"] = path_radiance(table, h, view, azimuth);
  if (table.has("path_radiance_thermal")) out["path_radiance_thermal"] = path_radiance_thermal(table, h, view);
  if (table.has("spherical_albedo")) out["spherical_albedo"] = spherical_albedo(table, h);
  if (table.has("diffuse_view_transmission"))
    out["diffuse_view_transmission"] = diffuse_view_transmission(table, h, view);

  // Spectra of the sky straight up and slanted, moved into what the table covers.
  if (table.axes.count("sky_zenith")) {
    const auto [low, high] = readable(table, "sky_zenith", 90);
    const double up = std::clamp(0.0, low, high), slant = std::clamp(60.0, low, high);
    out["sky_zenith_deg"] = {up, slant};
    if (table.has("sky_radiance_solar")) {
      const auto [first, last] = readable(table, "sky_azimuth", 180);
      const double side = std::clamp(fold_azimuth(azimuth), first, last);
      out["sky_azimuth_deg"] = side;
      out["sky_up"] = sky_radiance(table, h, up, side), out["sky_slant"] = sky_radiance(table, h, slant, side);
      out["sky"] = sky_map(table, h, nearest_node(wavelengths(table), choice.sky_wavelength_um));
    }
    if (table.has("sky_radiance_thermal")) {
      out["thermal_sky_up"] = sky_radiance_thermal(table, h, up),
      out["thermal_sky_slant"] = sky_radiance_thermal(table, h, slant);
      out["thermal_sky"] = thermal_sky(table, h);
    }
    if (table.has("diffuse_return"))
      out["diffuse_return_up"] = diffuse_return(table, h, up),
      out["diffuse_return_slant"] = diffuse_return(table, h, slant);
  }
  return out.dump();
}

}  // namespace raycube::atmos
