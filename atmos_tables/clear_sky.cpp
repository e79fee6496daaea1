#include "atmos_tables/clear_sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/rayleigh.h"
#include "atmos_tables/single_scatter.h"
#include "atmos_tables/table_rows.h"
#include "atmos_tables/wave_column.h"

namespace raycube::atmos {

namespace {

constexpr double kPi = std::numbers::pi;
const std::vector<double> kViewZeniths = {0, 10, 20, 30, 40, 50, 60, 70, 80};
const std::vector<double> kViewAzimuths = {0, 30, 60, 90, 120, 150, 180};
const std::vector<double> kSkyZeniths = {0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 84, 87, 89, 90};
const std::vector<double> kSkyAzimuths = {0, 10, 20, 30, 50, 70, 90, 120, 150, 180};

double radians(double degrees) { return degrees * kPi / 180; }

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

std::string provenance(const scene::AtmosphereSpec& spec, const scene::Sun& sun) {
  nlohmann::json j;
  j["model"] = "raycube built-in clear sky";
  j["sources"] = {"Bird & Riordan 1986 (gases, diffuse irradiance)", "Bodhaine et al. 1999 (Rayleigh)",
                  "Henyey & Greenstein 1941 (aerosol phase)", "Lacis & Hansen 1974 (ozone profile)", "Spencer 1971"};
  j["parameters"] = {{"ground_height_m", spec.ground_height_m},
                     {"pressure_hPa", spec.pressure_hPa},
                     {"water_g_cm2", spec.water_g_cm2},
                     {"ozone_atm_cm", spec.ozone_atm_cm},
                     {"aod_550", spec.aod_550},
                     {"angstrom", spec.angstrom},
                     {"ssa_400nm", spec.ssa},
                     {"asymmetry", spec.asymmetry},
                     {"ground_albedo", spec.ground_albedo},
                     {"day_of_year", sun.day_of_year}};
  j["stated_errors"] = {
      {"transmission",
       "band means within 0.025 of LOWTRAN7 and MODTRAN 6 (sun to ground 0.04); 5 nm channels rms 0.02 to 0.09"},
      {"two_way_factor", "T_sun T_view (1 - R2) within 0.02 of LOWTRAN7"},
      {"diffuse_irradiance", "0.45-0.88 um within 6 % of DISORT at the ground, 10 % at 0.6 km; 0.42 um -11 %"},
      {"sky_radiance_solar", "0.45-0.88 um within 17 % of DISORT by direction to 85 deg; below 0.45 um up to -30 %"},
      {"path_radiance_solar", "0.45-0.88 um from 0.6 km nadir within 6 %, 45 deg 13 %, from 3 km 17 % of DISORT"}};
  j["limits"] = {"no thermal emission", "no polarisation", "no refraction",
                 "rough for sun or view zeniths above 80 deg",
                 "single-parameter aerosol: Henyey-Greenstein misses the backscatter lobe"};
  return j.dump();
}

}  // namespace

RenderTable build_clear_sky(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                            const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m) {
  check_clear_sky(spec, sun, sensor_height_m, wavelength_um, target_height_m);

  RenderTable table = sunlit_table(sun, sensor_height_m, wavelength_um, target_height_m);
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
    for (double zenith : kViewZeniths)
      view_paths.push_back(make_path(air, level[h], sensor, zenith, false, spec.asymmetry));
    for (double zenith : kSkyZeniths) sky_paths.push_back(make_path(air, level[h], top, zenith, true, spec.asymmetry));
    for (double mu : quadrature.node)
      flux_paths.push_back(make_path(air, level[h], top, std::acos(mu) * 180 / kPi, true, spec.asymmetry));
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
  Row& phase_mean =
      add_row(table, "sky_phase_mean", "Rayleigh and Henyey-Greenstein by scattering depth above the target");
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
    const WaveColumn::Fluxes fluxes = wave.fluxes();

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
        const WaveColumn::Single single = wave.single(path);
        const double diffuse = wave.scattered_diffuse(path, fluxes);
        for (std::size_t z = 0; z < azimuths; ++z) {
          const double c = scattering_cosine(cos_sun, kViewZeniths[v], kViewAzimuths[z], false);
          const double once = ((a + b * c * c) * single.rayleigh + aerosol_phase(c) * single.aerosol) / (4 * kPi);
          l_path.values[(at * views + v) * azimuths + z] = static_cast<float>(e0 * (once + diffuse));
        }
      }

      // Horizontal irradiance of the sky's once-scattered and of its further part.
      double once_irradiance = 0, more_irradiance = 0;
      for (std::size_t q = 0; day && q < quadrature.node.size(); ++q) {
        const Path& path = flux_paths[h * quadrature.node.size() + q];
        const WaveColumn::Single single = wave.single(path);
        const double weight = 2 * kPi * quadrature.weight[q] * quadrature.node[q];
        once_irradiance +=
            weight * ((a + b * square_mean[q]) * single.rayleigh + aerosol_mean[q] * single.aerosol) / (4 * kPi);
        more_irradiance += weight * wave.scattered_diffuse(path, fluxes);
      }
      const double black = day ? wave.diffuse_black(level[h], true) : 0;
      const double from_ground = day ? wave.diffuse_from_ground(level[h]) : 0;
      e_dif.values[at] = static_cast<float>(e0 * (black + from_ground));
      // The further part carries what Bird & Riordan's irradiance leaves; where that is nothing, the first part
      // shrinks.
      const bool room = black > once_irradiance && more_irradiance > 0;
      const double scale_once = room ? 1 : once_irradiance > 0 ? black / once_irradiance : 0;
      const double scale_more = room ? (black - once_irradiance) / more_irradiance : 0;
      const double uniform = (from_ground + (once_irradiance > 0 ? 0 : black)) / kPi;
      ColumnShare above;
      for (std::size_t l = level[h]; l < top; ++l) above += air.share(l);
      shape_depth.values[at] = static_cast<float>(wave.scatter_depth(above));
      const double rayleigh = wave.rayleigh_total() * above.air, aerosol = wave.aerosol_scatter_total() * above.aerosol;
      for (std::size_t s = 0; s < angles.size(); ++s) {
        const double c = std::cos(radians(angles[s]));
        const double total = rayleigh + aerosol;
        phase_mean.values[at * angles.size() + s] =
            static_cast<float>(total > 0 ? (rayleigh * (a + b * c * c) + aerosol * aerosol_phase(c)) / total : 1.0);
      }
      for (std::size_t v = 0; day && v < zeniths; ++v) {
        const WaveColumn::Single single = wave.single(sky_paths[h * zeniths + v]);
        const double more = scale_more * wave.scattered_diffuse(sky_paths[h * zeniths + v], fluxes) + uniform;
        for (std::size_t z = 0; z < sky_azimuths; ++z) {
          const double c = scattering_cosine(cos_sun, kSkyZeniths[v], kSkyAzimuths[z], true);
          const double once = ((a + b * c * c) * single.rayleigh + aerosol_phase(c) * single.aerosol) / (4 * kPi);
          l_sky.values[(at * zeniths + v) * sky_azimuths + z] = static_cast<float>(e0 * (scale_once * once + more));
        }
      }
    }
  }
  validate(table, "clear sky");
  return table;
}

}  // namespace raycube::atmos
