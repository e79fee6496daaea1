#include "atmos_tables/clear_sky.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/rayleigh.h"
#include "atmos_tables/single_scatter.h"
#include "atmos_tables/table_rows.h"
#include "atmos_tables/wave_column.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

const std::vector<double> kViewZeniths = {0, 10, 20, 30, 40, 50, 60, 70, kModelLastView_deg};
const std::vector<double> kViewAzimuths = {0, 30, 60, 90, 120, 150, 180};
const std::vector<double> kSkyZeniths = {0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 84, 87, 89, 90};
const std::vector<double> kSkyAzimuths = {0, 10, 20, 30, 50, 70, 90, 120, 150, 180};

/// The user's, or the model's own.
const std::vector<double>& view_zeniths_of(const scene::AtmosphereSpec& spec) {
  return spec.view_zenith_deg.empty() ? kViewZeniths : spec.view_zenith_deg;
}

/// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
struct Quadrature {
  std::vector<double> node, weight;
};
Quadrature gauss_legendre(int count) {
  Quadrature q;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(base::kPi * (i + 0.75) / (count + 0.5)), slope = 1;
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

std::string provenance(const scene::AtmosphereSpec& spec, const scene::Sun& sun,
                       const std::optional<std::string>& notice) {
  nlohmann::json j;
  if (notice) j["notices"] = {*notice};
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

std::vector<double> with_sensor(std::vector<double> heights_m, double sensor_height_m) {
  heights_m.push_back(sensor_height_m);
  return heights_m;
}

/// Straight paths through the air that all wavelengths share, and what the sun's path down to each level crosses.
struct SkyGeometry {
  std::vector<double> view_zeniths;
  bool day;
  double cos_sun;  ///< 0 at night
  AirColumn air;
  std::size_t top;                                      ///< level
  std::vector<std::size_t> level;                       ///< of each target height
  std::vector<Path> view_paths, sky_paths, flux_paths;  ///< [height][zenith of the table, or node of the quadrature]
  std::vector<ColumnShare> sun_share;                   ///< [level]

  SkyGeometry(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
              const std::vector<double>& target_height_m, const Quadrature& quadrature)
      : view_zeniths(view_zeniths_of(spec)),
        day(sun.zenith_deg < 90),
        cos_sun(day ? std::cos(base::rad_by_division(sun.zenith_deg)) : 0),
        air(with_sensor(target_height_m, sensor_height_m), spec.ground_height_m),
        top(air.layers()),
        sun_share(air.levels().size()) {
    const std::size_t sensor = air.level_of(sensor_height_m);
    for (const double height_m : target_height_m) {
      const std::size_t from = level.emplace_back(air.level_of(height_m));
      for (double zenith : view_zeniths)
        view_paths.push_back(make_path(air, from, sensor, zenith, false, spec.asymmetry));
      for (double zenith : kSkyZeniths) sky_paths.push_back(make_path(air, from, top, zenith, true, spec.asymmetry));
      for (double mu : quadrature.node)
        flux_paths.push_back(make_path(air, from, top, base::deg_by_division(std::acos(mu)), true, spec.asymmetry));
    }
    for (std::size_t l = 0; l < top; ++l) {
      const std::vector<double> slant = air.slant(l, day ? sun.zenith_deg : 0);
      for (std::size_t i = l; i < top; ++i) sun_share[l] += slant[i] * air.share(i);
    }
  }
};

/// The rows of the table, in the order of the registry.
struct SkyRows {
  Row &t_sun, &d_sun, &t_view, &d_view, &factor, &l_path, &l_sky, &phase_mean, &shape_depth, &e_dir, &e_dif;
};

SkyRows add_rows(RenderTable& table) {
  const char* beer = "Bird & Riordan 1986 gases by total path amount, Bodhaine 1999, Angstrom; spherical shells";
  return {
      add_row(table, "sun_transmission", beer),
      add_row(table, "sun_optical_depth", beer),
      add_row(table, "view_transmission", beer),
      add_row(table, "view_optical_depth", beer),
      add_row(table, "two_way_factor", "gas transmittance of the joined path over the product of both"),
      add_row(table, "path_radiance_solar", "single scattering per layer plus scattered diffuse fluxes"),
      add_row(table, "sky_radiance_solar", "single scattering per layer, scaled to the diffuse irradiance"),
      add_row(table, "sky_phase_mean", "Rayleigh and Henyey-Greenstein by scattering depth above the target"),
      add_row(table, "sky_scattering_depth", "Rayleigh and aerosol extinction above the target"),
      add_row(table, "direct_irradiance", "E0 cos(sun zenith) T_sun"),
      add_row(table, "diffuse_irradiance", "Bird & Riordan 1986, eq. 3-5 .. 3-17"),
  };
}

/// Mean over azimuth, at each node of the quadrature, of the aerosol's phase function, which does not depend on
/// wavelength, and of the squared cosine of Rayleigh's: for the sky's irradiance.
struct AzimuthMeans {
  std::vector<double> aerosol, square;
};

AzimuthMeans azimuth_means(const Quadrature& quadrature, double cos_sun, double asymmetry) {
  const auto azimuth_mean = [&](double mu, auto&& phase) {
    double sum = 0;
    constexpr int kSteps = 90;
    for (int i = 0; i < kSteps; ++i)
      sum += phase(scattering_cosine(cos_sun, base::deg_by_division(std::acos(mu)), 180.0 * (i + 0.5) / kSteps, true));
    return sum / kSteps;
  };
  AzimuthMeans out;
  for (double mu : quadrature.node) {
    out.aerosol.push_back(azimuth_mean(mu, [&](double c) { return phase_henyey_greenstein(asymmetry, c); }));
    out.square.push_back(azimuth_mean(mu, [](double c) { return c * c; }));
  }
  return out;
}

/// Fills the rows of one wavelength, height by height.
class SkyLine {
 public:
  /// Keeps references. line: number of the wavelength; e0: the sun's irradiance above the air, 0 at night.
  SkyLine(const SkyGeometry& geometry, const Quadrature& quadrature, const AzimuthMeans& means,
          const scene::AtmosphereSpec& spec, const std::vector<double>& angles_deg, std::size_t line,
          double wavelength_um, double e0)
      : geometry_(geometry),
        quadrature_(quadrature),
        means_(means),
        asymmetry_(spec.asymmetry),
        angles_deg_(angles_deg),
        line_(line),
        e0_(e0),
        wave_(geometry.air, geometry.sun_share, spec, wavelength_um, geometry.cos_sun),
        fluxes_(wave_.fluxes()) {
    const double depolarization = rayleigh_depolarization(wavelength_um);
    a_ = phase_rayleigh(depolarization, 0), b_ = phase_rayleigh(depolarization, 1) - a_;
  }

  void fill(const SkyRows& rows) const {
    for (std::size_t h = 0; h < geometry_.level.size(); ++h) {
      const std::size_t at = line_ * geometry_.level.size() + h;
      fill_sun(rows, h, at);
      fill_view(rows, h, at);
      fill_scatterers(rows, h, at);
      const SkyScale scale = scale_to_diffuse(h);
      rows.e_dif.values[at] = static_cast<float>(e0_ * (scale.black + scale.from_ground));
      if (geometry_.day) fill_sky(rows, h, at, scale);
    }
  }

 private:
  /// Irradiance of the sky over e0, and the factors that bring its radiance to that.
  struct SkyScale {
    double black = 0, from_ground = 0;  ///< over black ground; what the ground adds
    double once = 0, more = 0;          ///< factors of the once-scattered and of the further part
    double uniform = 0;                 ///< radiance to add in all directions
  };

  double aerosol_phase(double cosine) const { return phase_henyey_greenstein(asymmetry_, cosine); }

  /// Once-scattered radiance over e0 by the cosine of the scattering angle.
  double once_scattered(const WaveColumn::Single& single, double c) const {
    return ((a_ + b_ * c * c) * single.rayleigh + aerosol_phase(c) * single.aerosol) / (4 * base::kPi);
  }

  void fill_sun(const SkyRows& rows, std::size_t h, std::size_t at) const {
    const ColumnShare& sun_path = geometry_.sun_share[geometry_.level[h]];
    const double sun_gas = wave_.gas_depth(sun_path), sun_total = wave_.scatter_depth(sun_path) + sun_gas;
    rows.d_sun.values[at] = static_cast<float>(sun_total);
    rows.t_sun.values[at] = static_cast<float>(std::exp(-sun_total));
    rows.e_dir.values[at] = static_cast<float>(e0_ * geometry_.cos_sun * std::exp(-sun_total));
  }

  /// The way to the sensor: transmission, the joined path's gases, path radiance.
  void fill_view(const SkyRows& rows, std::size_t h, std::size_t at) const {
    const ColumnShare& sun_path = geometry_.sun_share[geometry_.level[h]];
    const double sun_gas = wave_.gas_depth(sun_path);
    const std::size_t views = geometry_.view_zeniths.size(), azimuths = kViewAzimuths.size();
    for (std::size_t v = 0; v < views; ++v) {
      const Path& path = geometry_.view_paths[h * views + v];
      const double view_gas = wave_.gas_depth(path.share), depth = wave_.scatter_depth(path.share) + view_gas;
      rows.d_view.values[at * views + v] = static_cast<float>(depth);
      rows.t_view.values[at * views + v] = static_cast<float>(std::exp(-depth));
      rows.factor.values[at * views + v] =
          static_cast<float>(std::exp(sun_gas + view_gas - wave_.gas_depth(sun_path + path.share)));
      const WaveColumn::Single single = wave_.single(path);
      const double diffuse = wave_.scattered_diffuse(path, fluxes_);
      for (std::size_t z = 0; z < azimuths; ++z) {
        const double c = scattering_cosine(geometry_.cos_sun, geometry_.view_zeniths[v], kViewAzimuths[z], false);
        rows.l_path.values[(at * views + v) * azimuths + z] =
            static_cast<float>(e0_ * (once_scattered(single, c) + diffuse));
      }
    }
  }

  /// Depth and mean phase function of what scatters above the target.
  void fill_scatterers(const SkyRows& rows, std::size_t h, std::size_t at) const {
    ColumnShare above;
    for (std::size_t l = geometry_.level[h]; l < geometry_.top; ++l) above += geometry_.air.share(l);
    rows.shape_depth.values[at] = static_cast<float>(wave_.scatter_depth(above));
    const double rayleigh = wave_.rayleigh_total() * above.air, aerosol = wave_.aerosol_scatter_total() * above.aerosol;
    for (std::size_t s = 0; s < angles_deg_.size(); ++s) {
      const double c = std::cos(base::rad_by_division(angles_deg_[s]));
      const double total = rayleigh + aerosol;
      rows.phase_mean.values[at * angles_deg_.size() + s] =
          static_cast<float>(total > 0 ? (rayleigh * (a_ + b_ * c * c) + aerosol * aerosol_phase(c)) / total : 1.0);
    }
  }

  /// What brings the sky's radiances to Bird & Riordan's diffuse irradiance: its further part carries what that
  /// irradiance leaves; where that is nothing, the once-scattered part shrinks.
  SkyScale scale_to_diffuse(std::size_t h) const {
    double once_irradiance = 0, more_irradiance = 0;  // horizontal
    for (std::size_t q = 0; geometry_.day && q < quadrature_.node.size(); ++q) {
      const Path& path = geometry_.flux_paths[h * quadrature_.node.size() + q];
      const WaveColumn::Single single = wave_.single(path);
      const double weight = 2 * base::kPi * quadrature_.weight[q] * quadrature_.node[q];
      once_irradiance += weight *
                         ((a_ + b_ * means_.square[q]) * single.rayleigh + means_.aerosol[q] * single.aerosol) /
                         (4 * base::kPi);
      more_irradiance += weight * wave_.scattered_diffuse(path, fluxes_);
    }
    SkyScale out;
    out.black = geometry_.day ? wave_.diffuse_black(geometry_.level[h], true) : 0;
    out.from_ground = geometry_.day ? wave_.diffuse_from_ground(geometry_.level[h]) : 0;
    const bool room = out.black > once_irradiance && more_irradiance > 0;
    out.once = room ? 1 : once_irradiance > 0 ? out.black / once_irradiance : 0;
    out.more = room ? (out.black - once_irradiance) / more_irradiance : 0;
    out.uniform = (out.from_ground + (once_irradiance > 0 ? 0 : out.black)) / base::kPi;
    return out;
  }

  void fill_sky(const SkyRows& rows, std::size_t h, std::size_t at, const SkyScale& scale) const {
    const std::size_t zeniths = kSkyZeniths.size(), azimuths = kSkyAzimuths.size();
    for (std::size_t v = 0; v < zeniths; ++v) {
      const Path& path = geometry_.sky_paths[h * zeniths + v];
      const WaveColumn::Single single = wave_.single(path);
      const double more = scale.more * wave_.scattered_diffuse(path, fluxes_) + scale.uniform;
      for (std::size_t z = 0; z < azimuths; ++z) {
        const double c = scattering_cosine(geometry_.cos_sun, kSkyZeniths[v], kSkyAzimuths[z], true);
        rows.l_sky.values[(at * zeniths + v) * azimuths + z] =
            static_cast<float>(e0_ * (scale.once * once_scattered(single, c) + more));
      }
    }
  }

  const SkyGeometry& geometry_;
  const Quadrature& quadrature_;
  const AzimuthMeans& means_;
  double asymmetry_;
  const std::vector<double>& angles_deg_;
  std::size_t line_;
  double e0_;
  WaveColumn wave_;
  WaveColumn::Fluxes fluxes_;
  double a_ = 0, b_ = 0;  ///< P_rayleigh = a + b cos^2
};

}  // namespace

RenderTable build_clear_sky(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                            const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m) {
  check_clear_sky(spec, sun, sensor_height_m, wavelength_um, target_height_m);

  const SolarSpectrum solar(spec.solar);
  RenderTable table = sunlit_table(solar, sun, sensor_height_m, wavelength_um, target_height_m);
  table.provenance_json = provenance(spec, sun, solar.notice(wavelength_um.front(), wavelength_um.back()));
  add_axis(table, "view_zenith", view_zeniths_of(spec));
  add_axis(table, "relative_azimuth", kViewAzimuths);
  add_axis(table, "sky_zenith", kSkyZeniths);
  add_axis(table, "sky_azimuth", kSkyAzimuths);
  const std::vector<double> angles = scattering_angles();
  add_axis(table, "scattering_angle", angles);
  const SkyRows rows = add_rows(table);
  const Row& e0_row = table.rows.at("solar_irradiance");

  const Quadrature quadrature = gauss_legendre(24);
  const SkyGeometry geometry(spec, sun, sensor_height_m, target_height_m, quadrature);
  const AzimuthMeans means = azimuth_means(quadrature, geometry.cos_sun, spec.asymmetry);
  for (std::size_t i = 0; i < wavelength_um.size(); ++i) {
    const double e0 = geometry.day ? double(e0_row.values[i]) : 0.0;
    SkyLine(geometry, quadrature, means, spec, angles, i, wavelength_um[i], e0).fill(rows);
  }
  validate(table, "clear sky");
  return table;
}

}  // namespace raycube::atmos
