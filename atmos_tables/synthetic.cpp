#include "atmos_tables/synthetic.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/planck.h"
#include "host/base/units.h"

namespace raycube::atmos {

std::vector<double> wavelength_grid(double first_um, double last_um, double step_um) {
  if (!(step_um > 0) || !(last_um > first_um) || (last_um - first_um) / step_um > 1e7)
    throw base::Error(base::Fault::input, "wavelength grid " + std::to_string(first_um) + " to " +
                                              std::to_string(last_um) + " um in steps of " + std::to_string(step_um) +
                                              " um: needs first < last, a positive step and at most 1e7 steps");
  const auto steps = static_cast<std::size_t>(std::floor((last_um - first_um) / step_um * (1 + 1e-12)));
  std::vector<double> out;
  for (std::size_t i = 0; i <= steps; ++i) out.push_back(first_um + static_cast<double>(i) * step_um);
  if (last_um - out.back() > 1e-6 * step_um) out.push_back(last_um);
  return out;
}

std::vector<double> wavelength_grid_with_line(double first_um, double last_um, double step_um, double center_um,
                                              double half_width_um, double fine_step_um) {
  std::vector<double> out = wavelength_grid(first_um, last_um, step_um);
  const std::vector<double> fine = wavelength_grid(center_um - half_width_um, center_um + half_width_um, fine_step_um);
  std::erase_if(
      out, [&](double l) { return l > fine.front() - 0.5 * fine_step_um && l < fine.back() + 0.5 * fine_step_um; });
  out.insert(out.end(), fine.begin(), fine.end());
  std::sort(out.begin(), out.end());
  return out;
}

double gaussian_line(double wavelength_um, double center_um, double fwhm_um, double depth) {
  const double x = (wavelength_um - center_um) / fwhm_um;
  return std::exp(-depth * std::exp(-4 * std::numbers::ln2 * x * x));
}

RenderTable uniform_table(const UniformAir& air, const std::vector<double>& wavelength_um) {
  RenderTable table;
  table.solar_source = "stated by the caller";
  table.provenance_json = R"({"model":"uniform air, every spectrum stated by the caller"})";
  table.sun_zenith_deg = air.sun_zenith_deg;
  table.sun_azimuth_deg = air.sun_azimuth_deg;
  table.sensor_height_m = air.sensor_height_m;
  add_axis(table, "wavelength", wavelength_um);
  for (const char* name : {"target_height", "view_zenith", "relative_azimuth", "sky_zenith", "sky_azimuth"})
    add_axis(table, name, {0.0});
  const double mu0 = air.sun_zenith_deg < 90 ? std::cos(base::rad_by_division(air.sun_zenith_deg)) : 0;
  const auto fill = [&](const char* name, const UniformAir::Spectrum& spectrum) {
    Row& row = add_row(table, name, "stated by the caller");
    for (std::size_t i = 0; i < wavelength_um.size(); ++i)
      row.values[i] = static_cast<float>(spectrum(wavelength_um[i]));
  };
  fill("solar_irradiance", air.solar_irradiance);
  fill("sun_transmission", air.sun_transmission);
  fill("view_transmission", air.view_transmission);
  fill("two_way_factor", air.two_way_factor);
  fill("sky_radiance_solar", air.sky_radiance);
  fill("path_radiance_solar", air.path_radiance);
  if (air.thermal_sky_radiance && air.thermal_path_radiance) {
    fill("sky_radiance_thermal", air.thermal_sky_radiance);
    fill("path_radiance_thermal", air.thermal_path_radiance);
  }
  if (air.two_way_factor_thermal) fill("two_way_factor_thermal", air.two_way_factor_thermal);
  if (air.spherical_albedo) fill("spherical_albedo", air.spherical_albedo);
  if (air.diffuse_view_transmission) fill("diffuse_view_transmission", air.diffuse_view_transmission);
  if (air.diffuse_return) fill("diffuse_return", air.diffuse_return);
  fill("diffuse_irradiance", [&](double l) { return std::numbers::pi * air.sky_radiance(l); });
  fill("direct_irradiance", [&](double l) { return mu0 * air.solar_irradiance(l) * air.sun_transmission(l); });
  return table;
}

RenderTable isothermal_table(double temperature_K, const UniformAir::Spectrum& depth, double sensor_height_m,
                             const std::vector<double>& wavelength_um) {
  RenderTable table;
  table.solar_source = "none";
  table.provenance_json = R"({"model":"isothermal air that absorbs and emits, no sun"})";
  table.sun_zenith_deg = 180;
  table.sensor_height_m = sensor_height_m;
  constexpr double scale_height_m = 2000;
  const auto above = [](double z) { return std::exp(-z / scale_height_m); };  // part of the column above a height
  add_axis(table, "wavelength", wavelength_um);
  std::vector<double> heights;
  for (const double part : {0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0}) heights.push_back(part * sensor_height_m);
  add_axis(table, "target_height", heights);
  const std::vector<double> views = {0, 20, 40, 55, 65, 75, 80},
                            zeniths = {0, 30, 45, 60, 70, 75, 80, 83, 85, 87, 88.5, 90};
  add_axis(table, "view_zenith", views);
  add_axis(table, "sky_zenith", zeniths);
  Row& transmission = add_row(table, "view_transmission", "isothermal air");
  Row& path = add_row(table, "path_radiance_thermal", "isothermal air");
  Row& sky = add_row(table, "sky_radiance_thermal", "isothermal air under a black sky");
  std::size_t at_view = 0, at_sky = 0;
  for (const double l : wavelength_um) {
    const double tau = depth(l), source = base::planck_radiance(l, temperature_K);
    for (const double z : heights) {
      for (const double view : views) {
        const double t = std::exp(-tau * (above(z) - above(sensor_height_m)) / std::cos(base::rad_by_division(view)));
        transmission.values[at_view] = static_cast<float>(t);
        path.values[at_view++] = static_cast<float>(source * (1 - t));
      }
      for (const double zenith : zeniths)
        sky.values[at_sky++] = static_cast<float>(-source * std::expm1(-tau * above(z) * airmass(zenith)));
    }
  }
  return table;
}

RenderTable uniform_sky_table(double solar_irradiance, double sky_radiance, const std::vector<double>& wavelength_um,
                              double sun_zenith_deg, double sun_azimuth_deg) {
  UniformAir air;
  air.solar_irradiance = [=](double) { return solar_irradiance; };
  air.sky_radiance = [=](double) { return sky_radiance; };
  air.sun_zenith_deg = sun_zenith_deg;
  air.sun_azimuth_deg = sun_azimuth_deg;
  return uniform_table(air, wavelength_um);
}

}  // namespace raycube::atmos
