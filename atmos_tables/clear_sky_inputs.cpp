#include "atmos_tables/clear_sky_inputs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "atmos_tables/air_column.h"
#include "atmos_tables/bird_riordan.h"
#include "atmos_tables/clear_sky.h"
#include "atmos_tables/moon.h"
#include "atmos_tables/rct_file.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/text.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

/// A node speaks for at most this part of its wavelength on either side: further apart, nodes are samples.
constexpr double kWidestHalf = 0.05;
constexpr double kLastViewZenith_deg = 89.9;  ///< of the table's axis
constexpr double kLastMoon_um = 30;           ///< its albedo is constant from 5 um on

std::string json_number(double value) {
  return std::isfinite(value) ? nlohmann::json(value).dump() : "not a finite number";
}

/// Beyond this reflected sunlight is nothing beside what anything at 250 K emits.
constexpr double kReflectedTo_um = 5;
/// End of astronomical twilight: a zenith angle of the sun.
constexpr double kNight_deg = 108;

void check_range(base::Problems& problems, const char* name, double value, double low, double high, const char* unit) {
  if (value >= low && value <= high) return;
  problems.add({"", 0, 0, std::string("atmosphere.") + name},
               "must lie in " + json_number(low) + " to " + json_number(high) + (*unit ? std::string(" ") + unit : ""),
               json_number(value), "correct the value");
}

void check_grid(base::Problems& problems, double sensor_height_m, const std::vector<double>& wavelength_um,
                const std::vector<double>& target_height_m, double first_um, double last_um,
                const char* model = "the built-in model") {
  const base::Where grid{"", 0, 0, "atmosphere wavelengths"}, heights{"", 0, 0, "atmosphere target heights"};
  const auto ascending = [](const std::vector<double>& list) {
    return !list.empty() &&
           std::adjacent_find(list.begin(), list.end(), [](double a, double b) { return !(a < b); }) == list.end();
  };
  if (!ascending(wavelength_um))
    problems.add(grid, "must ascend strictly, at least one", base::counted(wavelength_um.size(), "value"), "sort them");
  else if (!(wavelength_um.front() >= first_um && wavelength_um.back() <= last_um))
    problems.add(
        grid,
        std::string(model) + " covers " + json_number(first_um) + " to " + json_number(last_um) + " um and ends there",
        json_number(wavelength_um.front()) + " to " + json_number(wavelength_um.back()) + " um",
        "narrow the bands, or import a table that reaches further");
  if (!(sensor_height_m >= -1000 && sensor_height_m <= 1e9))
    problems.add({"", 0, 0, "sensor height"}, "must lie in -1000 to 1e9 m", json_number(sensor_height_m),
                 "correct the height");
  if (!ascending(target_height_m))
    problems.add(heights, "must ascend strictly, at least one", base::counted(target_height_m.size(), "value"),
                 "sort them");
  else if (!(target_height_m.front() >= -1000))
    problems.add(heights, "must not lie below -1000 m", json_number(target_height_m.front()),
                 "move the scene's origin down");
  else if (!(target_height_m.back() <= std::min(sensor_height_m, kTopOfAir_m)))
    problems.add(heights,
                 "no target may lie above the sensor (" + json_number(sensor_height_m) + " m) or the air (100 km)",
                 json_number(target_height_m.back()) + " m", "raise the sensor or drop the height");
}

void check_sun(base::Problems& problems, const scene::Sun& sun) {
  const base::Where where{"", 0, 0, "sun"};
  if (!(sun.zenith_deg >= 0 && sun.zenith_deg <= 180))
    problems.add(where, "zenith must lie in 0 to 180 deg", json_number(sun.zenith_deg), "correct the angle");
  if (!(sun.moon_phase_deg <= 180))
    problems.add(where, "phase angle of the moon must lie in 0 to 180 deg", json_number(sun.moon_phase_deg),
                 "correct the angle");
  if (!(sun.azimuth_deg >= -360 && sun.azimuth_deg <= 360))
    problems.add(where, "azimuth must lie in -360 to 360 deg", json_number(sun.azimuth_deg), "correct the angle");
  if (sun.day_of_year < 0 || sun.day_of_year > 366)
    problems.add(where, "day of year must lie in 0 to 366", std::to_string(sun.day_of_year), "correct the date");
}

}  // namespace

void check_clear_sky(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                     const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m) {
  base::Problems problems;
  check_range(problems, "ground_height_m", spec.ground_height_m, -500, 9000, "m");
  check_range(problems, "pressure_hPa", spec.pressure_hPa, 1, 1200, "hPa");
  check_range(problems, "water_g_cm2", spec.water_g_cm2, 0, 10, "g cm-2");
  check_range(problems, "ozone_atm_cm", spec.ozone_atm_cm, 0, 1, "atm-cm");
  check_range(problems, "aod_550", spec.aod_550, 0, 5, "");
  check_range(problems, "angstrom", spec.angstrom, -1, 5, "");
  check_range(problems, "ssa", spec.ssa, 0, 1, "");
  check_range(problems, "asymmetry", spec.asymmetry, -0.95, 0.95, "");
  check_range(problems, "ground_albedo", spec.ground_albedo, 0, 1, "");
  check_sun(problems, sun);
  check_grid(problems, sensor_height_m, wavelength_um, target_height_m, kClearSkyFirst_um, kClearSkyLast_um);
  problems.throw_if_any();
  check_view_zeniths(spec.view_zenith_deg);
  static_cast<void>(SolarSpectrum(spec.solar));  // refuses what it cannot take
}

void check_table_request(const scene::Sun& sun, double sensor_height_m, const std::vector<double>& wavelength_um,
                         const std::vector<double>& target_height_m, double first_um, double last_um) {
  base::Problems problems;
  check_sun(problems, sun);
  check_grid(problems, sensor_height_m, wavelength_um, target_height_m, first_um, last_um);
  problems.throw_if_any();
}

void check_view_zeniths(const std::vector<double>& view_zenith_deg) {
  base::Problems problems;
  const base::Where where{"", 0, 0, "atmosphere view zeniths"};
  if (view_zenith_deg.size() == 1)
    problems.add(where, "must be two or more: a table of one says that the air is the same along all paths",
                 json_number(view_zenith_deg[0]) + " deg", "add the others that will be looked along");
  for (std::size_t i = 0; i < view_zenith_deg.size(); ++i) {
    const double angle = view_zenith_deg[i];
    if (!(angle >= 0 && angle <= kLastViewZenith_deg))
      problems.add(where, "must lie in 0 to " + json_number(kLastViewZenith_deg) + " deg", json_number(angle),
                   "correct the angle");
    if (i > 0 && !(angle > view_zenith_deg[i - 1]))
      problems.add(where, "must ascend strictly", json_number(view_zenith_deg[i - 1]) + " then " + json_number(angle),
                   "sort them and remove doubles");
  }
  problems.throw_if_any();
}

double last_view_zenith_deg(const scene::AtmosphereSpec& spec) {
  return spec.view_zenith_deg.empty() ? kModelLastView_deg : spec.view_zenith_deg.back();
}

std::optional<std::string> no_light_notice(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double first_um) {
  if (!spec.table_file.empty() || sun.zenith_deg < 90 || !(first_um < kReflectedTo_um)) return std::nullopt;
  const std::string bands = ", below the horizon: bands below " + json_number(kReflectedTo_um) + " um hold no ";
  if (sun.moon_phase_deg >= 0)
    return "the moon stands at a zenith angle of " + json_number(sun.zenith_deg) + " deg" + bands + "light of it";
  return "the sun stands at a zenith angle of " + json_number(sun.zenith_deg) + " deg" + bands +
         "sunlight, and there is no twilight" +
         (sun.zenith_deg < kNight_deg && !spec.none
              ? " (90 to 108 deg) in the built-in models; import a table of a code that has it"
              : "");
}

NodeSpan node_span(const std::vector<double>& wavelength_um, std::size_t i) {
  const double here = wavelength_um[i], widest = kWidestHalf * here;
  const bool last = i + 1 == wavelength_um.size();
  double below = i > 0 ? std::min(0.5 * (here - wavelength_um[i - 1]), widest) : 0;
  double above = last ? 0 : std::min(0.5 * (wavelength_um[i + 1] - here), widest);
  if (i == 0) below = above;
  if (last) above = below;
  return {here - below, here + above};
}

RenderTable sunlit_table(const SolarSpectrum& solar, const scene::Sun& sun, double sensor_height_m,
                         const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m) {
  RenderTable table;
  const bool moon = sun.moon_phase_deg >= 0;
  const std::string source = moon ? moon_source_name() + ", of sunlight by " + solar.source() : solar.source();
  table.solar_source = source;
  table.sun_zenith_deg = sun.zenith_deg;
  table.sun_azimuth_deg = sun.azimuth_deg;
  table.sensor_height_m = sensor_height_m;
  add_axis(table, "wavelength", wavelength_um);
  add_axis(table, "target_height", target_height_m);
  Row& e0 = add_row(table, "solar_irradiance", source + ", times Spencer's earth-sun factor");
  const double factor = earth_sun_factor(sun.day_of_year);
  for (std::size_t i = 0; i < wavelength_um.size(); ++i) {
    const NodeSpan span = node_span(wavelength_um, i);
    const double at_1au =
        solar.is_file() ? solar.mean_1au(span.from_um, span.to_um) : solar.irradiance_1au(wavelength_um[i]);
    e0.values[i] = static_cast<float>(
        factor * at_1au * (moon ? moon_over_sun(sun.moon_phase_deg, std::min(wavelength_um[i], kLastMoon_um)) : 1.0));
  }
  return table;
}

void add_steps(std::vector<double>& wavelength_um, double first_um, double last_um, const WavelengthSpan& span) {
  const double low = std::max(span.low_um, first_um), high = std::min(span.high_um, last_um), step = span.step_um;
  if (!(low < high)) return;
  // Nodes are counted, not added up, so that none carries the rounding of those before it.
  for (std::size_t i = 0; low + static_cast<double>(i) * step < high - 1e-9 * step; ++i)
    wavelength_um.push_back(low + static_cast<double>(i) * step);
}

namespace {

/// first_um, last_um and the steps of the spans between them; step_um > 0 replaces those.
std::vector<double> span_nodes(double first_um, double last_um, double step_um,
                               const std::vector<WavelengthSpan>& spans) {
  std::vector<double> out;
  if (step_um > 0) {
    add_steps(out, first_um, last_um, {first_um, last_um, step_um});
  } else {
    for (const WavelengthSpan& span : spans) add_steps(out, first_um, last_um, span);
  }
  if (last_um - out.back() < 1e-9) out.pop_back();
  out.push_back(last_um);
  return out;
}

void check_range_and_step(double first_um, double last_um, double step_um, double least_um, double most_um,
                          const char* model, const char* way_out) {
  base::Problems problems;
  if (!(first_um >= least_um && last_um <= most_um && first_um < last_um))
    problems.add(
        {"", 0, 0, "atmosphere wavelengths"},
        std::string(model) + " covers " + json_number(least_um) + " to " + json_number(most_um) + " um and ends there",
        json_number(first_um) + " to " + json_number(last_um) + " um", way_out);
  if (!(step_um >= 0) || (step_um > 0 && (last_um - first_um) / step_um > 1e6))
    problems.add({"", 0, 0, "atmosphere wavelength step"}, "must be positive and give at most 1e6 wavelengths",
                 json_number(step_um) + " um", "choose a wider step");
  problems.throw_if_any();
}

}  // namespace

std::vector<double> clear_sky_wavelengths(double first_um, double last_um, double step_um) {
  check_range_and_step(first_um, last_um, step_um, kClearSkyFirst_um, kClearSkyLast_um, "the built-in model",
                       "narrow the range, or import a table");
  return span_nodes(first_um, last_um, step_um, {{0, 1.0, 0.001}, {1.0, 2.5, 0.002}, {2.5, 4.1, 0.01}});
}

std::vector<double> vacuum_wavelengths(double first_um, double last_um, double step_um) {
  check_range_and_step(first_um, last_um, step_um, kClearSkyFirst_um, kVacuumLast_um, "model = \"none\"",
                       "narrow the range");
  return span_nodes(first_um, last_um, step_um,
                    {{0, 1.0, 0.001}, {1.0, 2.5, 0.002}, {2.5, 10, 0.01}, {10, 100, 0.05}, {100, 1001, 0.5}});
}

std::vector<double> clear_sky_heights(double low_m, double high_m) {
  if (!(high_m > low_m)) return {low_m};
  // Depth is exponential with the 2 km scale of water and aerosol: steps of 150 m leave (150/2000)^2/8 = 7e-4 of the
  // depth between nodes; at most 16 nodes, evenly spaced.
  const int steps = static_cast<int>(std::clamp(std::ceil((high_m - low_m) / 150), 1.0, 15.0));
  std::vector<double> out;
  for (int i = 0; i <= steps; ++i) out.push_back(low_m + (high_m - low_m) * i / steps);
  out.back() = high_m;
  return out;
}

RenderTable vacuum_table(const scene::Sun& sun, double sensor_height_m, const std::vector<double>& wavelength_um,
                         const std::vector<double>& target_height_m, const scene::SolarSpectrumSpec& spectrum) {
  base::Problems problems;
  check_sun(problems, sun);
  check_grid(problems, sensor_height_m, wavelength_um, target_height_m, kClearSkyFirst_um, kVacuumLast_um,
             "model = \"none\"");
  problems.throw_if_any();
  const SolarSpectrum solar(spectrum);
  RenderTable table = sunlit_table(solar, sun, sensor_height_m, wavelength_um, target_height_m);
  nlohmann::json provenance = {{"model", "vacuum"}, {"sources", {"no air: transmission 1, sky and path radiance 0"}}};
  if (const auto notice = solar.notice(wavelength_um.front(), wavelength_um.back())) provenance["notices"] = {*notice};
  table.provenance_json = provenance.dump();
  for (const char* name : {"view_zenith", "relative_azimuth", "sky_zenith", "sky_azimuth"})
    add_axis(table, name, {0.0});
  for (const char* name : {"sun_transmission", "view_transmission", "two_way_factor"}) {
    Row& row = add_row(table, name, "vacuum: exactly 1");
    std::fill(row.values.begin(), row.values.end(), 1.0f);
  }
  for (const char* name : {"path_radiance_solar", "sky_radiance_solar", "diffuse_irradiance"})
    add_row(table, name, "vacuum: exactly 0");
  const double mu0 = sun.zenith_deg < 90 ? std::cos(base::rad_by_division(sun.zenith_deg)) : 0;
  Row& direct = add_row(table, "direct_irradiance", "E0 cos(sun zenith); 0 with the sun at or below the horizon");
  const Row& e0 = table.rows.at("solar_irradiance");
  for (std::size_t i = 0; i < direct.values.size(); ++i)
    direct.values[i] = static_cast<float>(mu0 * e0.values[i / target_height_m.size()]);
  validate(table, "vacuum");
  return table;
}

RenderTable make_table(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                       const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m) {
  if (spec.none) return vacuum_table(sun, sensor_height_m, wavelength_um, target_height_m, spec.solar);
  if (spec.table_file.empty()) return build_clear_sky(spec, sun, sensor_height_m, wavelength_um, target_height_m);
  RenderTable table = read_rct(spec.table_file);
  base::Problems problems;
  const base::Where where{spec.table_file, 0, 0, ""};
  const char* way_out = "build the table for this simulation, or take sun and sensor from the table";
  if (!(std::abs(table.sun_zenith_deg - sun.zenith_deg) <= 0.01))
    problems.add(where, "is for another sun zenith than the simulation's " + json_number(sun.zenith_deg) + " deg",
                 json_number(table.sun_zenith_deg) + " deg", way_out);
  if (!(std::abs(std::remainder(table.sun_azimuth_deg - sun.azimuth_deg, 360.0)) <= 0.01))
    problems.add(where, "is for another sun azimuth than the simulation's " + json_number(sun.azimuth_deg) + " deg",
                 json_number(table.sun_azimuth_deg) + " deg", way_out);
  if (!(std::abs(table.sensor_height_m - sensor_height_m) <= 0.1))
    problems.add(where, "is for another sensor height than the simulation's " + json_number(sensor_height_m) + " m",
                 json_number(table.sensor_height_m) + " m", way_out);
  problems.throw_if_any();
  return table;
}

}  // namespace raycube::atmos
