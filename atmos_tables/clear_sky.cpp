#include "atmos_tables/clear_sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "atmos_tables/bird_riordan.h"
#include "atmos_tables/rayleigh.h"
#include "atmos_tables/single_scatter.h"
#include "atmos_tables/table_rows.h"
#include "atmos_tables/wave_column.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr double kPi = std::numbers::pi;
const std::vector<double> kViewZeniths = {0, 10, 20, 30, 40, 50, 60, 70, 80};
const std::vector<double> kViewAzimuths = {0, 30, 60, 90, 120, 150, 180};
const std::vector<double> kSkyZeniths = {0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 84, 87, 89, 90};
const std::vector<double> kSkyAzimuths = {0, 10, 20, 30, 50, 70, 90, 120, 150, 180};

double radians(double degrees) { return degrees * kPi / 180; }

std::string number(double value) {
  nlohmann::json text = value;
  return text.dump();
}

void check_range(base::Problems& problems, const char* name, double value, double low, double high, const char* unit) {
  if (value >= low && value <= high) return;
  problems.add({"", 0, 0, std::string("atmosphere.") + name},
               "must lie in " + number(low) + " to " + number(high) + (*unit ? std::string(" ") + unit : ""),
               std::isfinite(value) ? number(value) : "not a finite number", "correct the value");
}

void check_grid(base::Problems& problems, double sensor_height_m, const std::vector<double>& wavelength_um,
                const std::vector<double>& target_height_m, double first_um, double last_um) {
  const base::Where grid{"", 0, 0, "atmosphere wavelengths"}, heights{"", 0, 0, "atmosphere target heights"};
  const auto ascending = [](const std::vector<double>& list) {
    return !list.empty() && std::adjacent_find(list.begin(), list.end(), [](double a, double b) { return !(a < b); }) == list.end();
  };
  if (!ascending(wavelength_um))
    problems.add(grid, "must ascend strictly, at least one", std::to_string(wavelength_um.size()) + " values", "sort them");
  else if (!(wavelength_um.front() >= first_um && wavelength_um.back() <= last_um))
    problems.add(grid, "the built-in model covers " + number(first_um) + " to " + number(last_um) + " um and ends there",
                 number(wavelength_um.front()) + " to " + number(wavelength_um.back()) + " um",
                 "narrow the bands, or import a table that reaches further");
  if (!(sensor_height_m >= -1000 && sensor_height_m <= 1e9))
    problems.add({"", 0, 0, "sensor height"}, "must lie in -1000 to 1e9 m", number(sensor_height_m), "correct the height");
  if (!ascending(target_height_m))
    problems.add(heights, "must ascend strictly, at least one", std::to_string(target_height_m.size()) + " values", "sort them");
  else if (!(target_height_m.front() >= -1000))
    problems.add(heights, "must not lie below -1000 m", number(target_height_m.front()), "move the scene's origin down");
  else if (!(target_height_m.back() <= std::min(sensor_height_m, kTopOfAir_m)))
    problems.add(heights, "no target may lie above the sensor (" + number(sensor_height_m) + " m) or the air (100 km)",
                 number(target_height_m.back()) + " m", "raise the sensor or drop the height");
}

void check_sun(base::Problems& problems, const scene::Sun& sun) {
  const base::Where where{"", 0, 0, "sun"};
  if (!(sun.zenith_deg >= 0 && sun.zenith_deg <= 180))
    problems.add(where, "zenith must lie in 0 to 180 deg", number(sun.zenith_deg), "correct the angle");
  else if (sun.zenith_deg >= 90 && sun.zenith_deg < 108)
    problems.add(where, "the built-in model has no twilight (sun zenith 90 to 108 deg)", number(sun.zenith_deg) + " deg",
                 "choose a time with the sun up, or import a table");
  if (sun.day_of_year < 0 || sun.day_of_year > 366)
    problems.add(where, "day of year must lie in 0 to 366", std::to_string(sun.day_of_year), "correct the date");
}

/// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
struct Quadrature {
  std::vector<double> node, weight;
};
Quadrature gauss_legendre(int count) {
  Quadrature q;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (count + 0.5)), slope = 1;
    for (int step = 0; step < 100; ++step) {
      double p0 = 1, p1 = x;
      for (int n = 2; n <= count; ++n) {
        const double p2 = ((2 * n - 1) * x * p1 - (n - 1) * p0) / n;
        p0 = p1, p1 = p2;
      }
      slope = count * (x * p1 - p0) / (x * x - 1);
      const double change = p1 / slope;
      x -= change;
      if (std::abs(change) < 1e-15) break;
    }
    q.node.push_back(0.5 * (1 + x));
    q.weight.push_back(1 / ((1 - x * x) * slope * slope));
  }
  return q;
}

std::vector<double> scattering_angles() {
  std::vector<double> out;
  for (int i = 0; i < 10; ++i) out.push_back(i);
  for (int i = 10; i < 30; i += 2) out.push_back(i);
  for (int i = 30; i <= 180; i += 5) out.push_back(i);
  return out;
}

RenderTable bare_table(const scene::Sun& sun, double sensor_height_m, const std::vector<double>& wavelength_um,
                       const std::vector<double>& target_height_m) {
  RenderTable table;
  table.solar_source = solar_source_name();
  table.sun_zenith_deg = sun.zenith_deg;
  table.sun_azimuth_deg = sun.azimuth_deg;
  table.sensor_height_m = sensor_height_m;
  add_axis(table, "wavelength", wavelength_um);
  add_axis(table, "target_height", target_height_m);
  Row& e0 = add_row(table, "solar_irradiance", solar_source_name() + ", times Spencer's earth-sun factor");
  const double factor = earth_sun_factor(sun.day_of_year);
  for (std::size_t i = 0; i < wavelength_um.size(); ++i)
    e0.values[i] = static_cast<float>(factor * solar_irradiance_1au(wavelength_um[i]));
  return table;
}

std::string provenance(const scene::AtmosphereSpec& spec, const scene::Sun& sun) {
  nlohmann::json j;
  j["model"] = "raycube built-in clear sky";
  j["sources"] = {"Bird & Riordan 1986 (gases, diffuse irradiance)", "Bodhaine et al. 1999 (Rayleigh)",
                  "Henyey & Greenstein 1941 (aerosol phase)", "Lacis & Hansen 1974 (ozone profile)", "Spencer 1971"};
  j["parameters"] = {{"ground_height_m", spec.ground_height_m}, {"pressure_hPa", spec.pressure_hPa},
                     {"water_g_cm2", spec.water_g_cm2},         {"ozone_atm_cm", spec.ozone_atm_cm},
                     {"aod_550", spec.aod_550},                 {"angstrom", spec.angstrom},
                     {"ssa_400nm", spec.ssa},                   {"asymmetry", spec.asymmetry},
                     {"ground_albedo", spec.ground_albedo},     {"day_of_year", sun.day_of_year}};
  j["limits"] = {"no thermal emission", "no polarisation", "no refraction; zeniths above 80 deg are rough"};
  return j.dump();
}

}  // namespace

double solar_irradiance_1au(double wavelength_um) { return bird_riordan_at(wavelength_um).solar_irradiance; }
std::string solar_source_name() { return "Bird & Riordan 1986, 122 wavelengths (SPCTRL2)"; }

std::vector<double> clear_sky_wavelengths(double first_um, double last_um, double step_um) {
  base::Problems problems;
  if (!(first_um >= kClearSkyFirst_um && last_um <= kClearSkyLast_um && first_um < last_um))
    problems.add({"", 0, 0, "atmosphere wavelengths"}, "the built-in model covers 0.3 to 4 um and ends there",
                 number(first_um) + " to " + number(last_um) + " um", "narrow the range, or import a table");
  if (!(step_um >= 0) || (step_um > 0 && (last_um - first_um) / step_um > 1e6))
    problems.add({"", 0, 0, "atmosphere wavelength step"}, "must be positive and give at most 1e6 wavelengths",
                 number(step_um) + " um", "choose a wider step");
  problems.throw_if_any();
  std::vector<double> out;
  // Nodes are counted in picometres so that the grid does not depend on where it starts.
  const auto add_span = [&](double low, double high, double step) {
    low = std::max(low, first_um), high = std::min(high, last_um);
    if (!(low < high)) return;
    for (std::size_t i = 0; low + static_cast<double>(i) * step < high - 1e-9 * step; ++i)
      out.push_back(low + static_cast<double>(i) * step);
  };
  if (step_um > 0) {
    add_span(first_um, last_um, step_um);
  } else {
    add_span(0, 1.0, 0.001), add_span(1.0, 2.5, 0.002), add_span(2.5, 4.1, 0.01);
  }
  if (last_um - out.back() < 1e-9) out.pop_back();
  out.push_back(last_um);
  return out;
}

std::vector<double> clear_sky_heights(double low_m, double high_m) {
  if (!(high_m > low_m)) return {low_m};
  // Depth is exponential with the 2 km scale of water and aerosol: steps of 150 m leave (150/2000)^2/8 = 7e-4 of the depth
  // between nodes; at most 16 nodes, evenly spaced.
  const int steps = static_cast<int>(std::clamp(std::ceil((high_m - low_m) / 150), 1.0, 15.0));
  std::vector<double> out;
  for (int i = 0; i <= steps; ++i) out.push_back(low_m + (high_m - low_m) * i / steps);
  out.back() = high_m;
  return out;
}

RenderTable vacuum_table(const scene::Sun& sun, double sensor_height_m, const std::vector<double>& wavelength_um,
                         const std::vector<double>& target_height_m) {
  base::Problems problems;
  check_grid(problems, sensor_height_m, wavelength_um, target_height_m, kClearSkyFirst_um, kClearSkyLast_um);
  problems.throw_if_any();
  RenderTable table = bare_table(sun, sensor_height_m, wavelength_um, target_height_m);
  table.provenance_json = R"({"model":"vacuum","sources":["no air: transmission 1, sky and path radiance 0"]})";
  for (const char* name : {"view_zenith", "relative_azimuth", "sky_zenith", "sky_azimuth"}) add_axis(table, name, {0.0});
  for (const char* name : {"sun_transmission", "view_transmission", "two_way_factor"}) {
    Row& row = add_row(table, name, "vacuum: exactly 1");
    std::fill(row.values.begin(), row.values.end(), 1.0f);
  }
  for (const char* name : {"path_radiance_solar", "sky_radiance_solar", "diffuse_irradiance"})
    add_row(table, name, "vacuum: exactly 0");
  const double mu0 = sun.zenith_deg < 90 ? std::cos(radians(sun.zenith_deg)) : 0;
  Row& direct = add_row(table, "direct_irradiance", "E0 cos(sun zenith); 0 with the sun at or below the horizon");
  const Row& e0 = table.rows.at("solar_irradiance");
  for (std::size_t i = 0; i < direct.values.size(); ++i)
    direct.values[i] = static_cast<float>(mu0 * e0.values[i / target_height_m.size()]);
  validate(table, "vacuum");
  return table;
}

RenderTable build_clear_sky(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                            const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m) {
  base::Problems problems;
  check_range(problems, "ground_height_m", spec.ground_height_m, -500, 9000, "m");
  check_range(problems, "pressure_hPa", spec.pressure_hPa, 200, 1100, "hPa");
  check_range(problems, "water_g_cm2", spec.water_g_cm2, 0, 10, "g cm-2");
  check_range(problems, "ozone_atm_cm", spec.ozone_atm_cm, 0, 1, "atm-cm");
  check_range(problems, "aod_550", spec.aod_550, 0, 5, "");
  check_range(problems, "angstrom", spec.angstrom, -1, 4, "");
  check_range(problems, "ssa", spec.ssa, 0, 1, "");
  check_range(problems, "asymmetry", spec.asymmetry, 0, 0.95, "");
  check_range(problems, "ground_albedo", spec.ground_albedo, 0, 1, "");
  check_sun(problems, sun);
  check_grid(problems, sensor_height_m, wavelength_um, target_height_m, kClearSkyFirst_um, kClearSkyLast_um);
  problems.throw_if_any();

  RenderTable table = bare_table(sun, sensor_height_m, wavelength_um, target_height_m);
  table.provenance_json = provenance(spec, sun);
  add_axis(table, "view_zenith", kViewZeniths);
  add_axis(table, "relative_azimuth", kViewAzimuths);
  add_axis(table, "sky_zenith", kSkyZeniths);
  add_axis(table, "sky_azimuth", kSkyAzimuths);
  const std::vector<double> angles = scattering_angles();
  add_axis(table, "scattering_angle", angles);
  const bool day = sun.zenith_deg < 90;
  const double cos_sun = day ? std::cos(radians(sun.zenith_deg)) : 0;

  std::vector<double> marks = target_height_m;
  marks.push_back(sensor_height_m);
  const AirColumn air(marks, spec.ground_height_m);
  const std::size_t top = air.layers(), sensor = air.level_of(sensor_height_m);
  const std::size_t heights = target_height_m.size(), views = kViewZeniths.size(), azimuths = kViewAzimuths.size();
  const std::size_t zeniths = kSkyZeniths.size(), sky_azimuths = kSkyAzimuths.size();
  std::vector<std::size_t> level(heights);
  std::vector<Path> view_paths, sky_paths, flux_paths;
  const Quadrature quadrature = gauss_legendre(24);
  for (std::size_t h = 0; h < heights; ++h) {
    level[h] = air.level_of(target_height_m[h]);
    for (double zenith : kViewZeniths) view_paths.push_back(make_path(air, level[h], sensor, zenith, false));
    for (double zenith : kSkyZeniths) sky_paths.push_back(make_path(air, level[h], top, zenith, true));
    for (double mu : quadrature.node)
      flux_paths.push_back(make_path(air, level[h], top, std::acos(mu) * 180 / kPi, true));
  }
  std::vector<ColumnShare> sun_share(air.levels().size());
  for (std::size_t l = 0; l < top; ++l) {
    const std::vector<double> slant = air.slant(l, day ? sun.zenith_deg : 0);
    for (std::size_t i = l; i < top; ++i) sun_share[l] += slant[i] * air.share(i);
  }

  // Rows, in the order of the registry.
  const char* beer = "Bird & Riordan 1986 gases by total path amount, Bodhaine 1999, Angstrom; spherical shells";
  Row& t_sun = add_row(table, "sun_transmission", beer);
  Row& d_sun = add_row(table, "sun_optical_depth", beer);
  Row& t_view = add_row(table, "view_transmission", beer);
  Row& d_view = add_row(table, "view_optical_depth", beer);
  Row& factor = add_row(table, "two_way_factor", "gas transmittance of the joined path over the product of both");
  Row& l_path = add_row(table, "path_radiance_solar", "single scattering per layer plus scattered diffuse fluxes");
  Row& l_sky = add_row(table, "sky_radiance_solar", "single scattering per layer, scaled to the diffuse irradiance");
  Row& phase_mean = add_row(table, "sky_phase_mean", "Rayleigh and Henyey-Greenstein by scattering depth above the target");
  Row& shape_depth = add_row(table, "sky_scattering_depth", "Rayleigh and aerosol extinction above the target");
  Row& e_dir = add_row(table, "direct_irradiance", "E0 cos(sun zenith) T_sun");
  Row& e_dif = add_row(table, "diffuse_irradiance", "Bird & Riordan 1986, eq. 3-5 .. 3-17");
  const Row& e0_row = table.rows.at("solar_irradiance");

  // The aerosol's phase function does not depend on wavelength; azimuth means for the sky's irradiance.
  const auto aerosol_phase = [&](double cosine) { return phase_henyey_greenstein(spec.asymmetry, cosine); };
  const auto azimuth_mean = [&](double mu, auto&& phase) {
    double sum = 0;
    constexpr int kSteps = 90;
    for (int i = 0; i < kSteps; ++i)
      sum += phase(scattering_cosine(cos_sun, std::acos(mu) * 180 / kPi, 180.0 * (i + 0.5) / kSteps, true));
    return sum / kSteps;
  };
  std::vector<double> aerosol_mean, square_mean;
  for (double mu : quadrature.node) {
    aerosol_mean.push_back(azimuth_mean(mu, aerosol_phase));
    square_mean.push_back(azimuth_mean(mu, [](double c) { return c * c; }));
  }

  for (std::size_t i = 0; i < wavelength_um.size(); ++i) {
    const WaveColumn wave(air, sun_share, spec, wavelength_um[i], cos_sun);
    const double e0 = day ? double(e0_row.values[i]) : 0.0;
    const double depolarization = rayleigh_depolarization(wavelength_um[i]);
    // P_rayleigh = a + b cos^2.
    const double a = phase_rayleigh(depolarization, 0), b = phase_rayleigh(depolarization, 1) - a;
    std::vector<double> down(air.levels().size(), 0.0), up(air.levels().size(), 0.0);
    for (std::size_t l = 0; day && l < air.levels().size(); ++l)
      down[l] = wave.diffuse_black(l, false), up[l] = wave.diffuse_up(l, 0);

    for (std::size_t h = 0; h < heights; ++h) {
      const std::size_t at = i * heights + h;
      const ColumnShare& sun_path = sun_share[level[h]];
      const double sun_gas = wave.gas_depth(sun_path), sun_total = wave.scatter_depth(sun_path) + sun_gas;
      d_sun.values[at] = static_cast<float>(sun_total);
      t_sun.values[at] = static_cast<float>(std::exp(-sun_total));
      e_dir.values[at] = static_cast<float>(e0 * cos_sun * std::exp(-sun_total));

      for (std::size_t v = 0; v < views; ++v) {
        const Path& path = view_paths[h * views + v];
        const double view_gas = wave.gas_depth(path.share), depth = wave.scatter_depth(path.share) + view_gas;
        d_view.values[at * views + v] = static_cast<float>(depth);
        t_view.values[at * views + v] = static_cast<float>(std::exp(-depth));
        factor.values[at * views + v] =
            static_cast<float>(std::exp(sun_gas + view_gas - wave.gas_depth(sun_path + path.share)));
        const WaveColumn::Single single = wave.single_up(path);
        const double diffuse = wave.diffuse_into_path(path, down, up);
        for (std::size_t z = 0; z < azimuths; ++z) {
          const double c = scattering_cosine(cos_sun, kViewZeniths[v], kViewAzimuths[z], false);
          const double once = ((a + b * c * c) * single.rayleigh + aerosol_phase(c) * single.aerosol) / (4 * kPi);
          l_path.values[(at * views + v) * azimuths + z] = static_cast<float>(e0 * (once + diffuse));
        }
      }

      double single_irradiance = 0;
      for (std::size_t q = 0; day && q < quadrature.node.size(); ++q) {
        const WaveColumn::Single single = wave.single_down(flux_paths[h * quadrature.node.size() + q]);
        single_irradiance += 2 * kPi * quadrature.weight[q] * quadrature.node[q] *
                             ((a + b * square_mean[q]) * single.rayleigh + aerosol_mean[q] * single.aerosol) / (4 * kPi);
      }
      const double black = day ? wave.diffuse_black(level[h], true) : 0;
      const double from_ground = day ? wave.diffuse_from_ground(level[h]) : 0;
      e_dif.values[at] = static_cast<float>(e0 * (black + from_ground));
      const double scale = single_irradiance > 0 ? black / single_irradiance : 0;
      const double uniform = (from_ground + (single_irradiance > 0 ? 0 : black)) / kPi;
      ColumnShare above;
      for (std::size_t l = level[h]; l < top; ++l) above += air.share(l);
      shape_depth.values[at] = static_cast<float>(wave.scatter_depth(above));
      const double rayleigh = wave.rayleigh_total() * above.air, aerosol = wave.aerosol_scatter_total() * above.aerosol;
      for (std::size_t s = 0; s < angles.size(); ++s) {
        const double c = std::cos(radians(angles[s]));
        const double total = rayleigh + aerosol;
        phase_mean.values[at * angles.size() + s] = static_cast<float>(
            total > 0 ? (rayleigh * (a + b * c * c) + aerosol * aerosol_phase(c)) / total : 1.0);
      }
      for (std::size_t v = 0; day && v < zeniths; ++v) {
        const WaveColumn::Single single = wave.single_down(sky_paths[h * zeniths + v]);
        for (std::size_t z = 0; z < sky_azimuths; ++z) {
          const double c = scattering_cosine(cos_sun, kSkyZeniths[v], kSkyAzimuths[z], true);
          const double once = ((a + b * c * c) * single.rayleigh + aerosol_phase(c) * single.aerosol) / (4 * kPi);
          l_sky.values[(at * zeniths + v) * sky_azimuths + z] = static_cast<float>(e0 * (scale * once + uniform));
        }
      }
    }
  }
  validate(table, "clear sky");
  return table;
}

}  // namespace raycube::atmos
