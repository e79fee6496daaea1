#include "atmos_tables/compiler/bin_rows.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/table_rows.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

/// Azimuth orders past this part of the first are dropped: radiances change by less than 1e-4.
constexpr double kFourierTolerance = 1e-5;
/// Below this a transmission counts as none: ratios of such numbers carry nothing.
constexpr double kSmallestTransmission = 1e-30;
constexpr double kLargestFactorLog = 20;

const std::vector<double> kViewZenith_deg = {0, 10, 20, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, kModelLastView_deg};

/// Dense in the aureole, where tabulated Mie functions have a cusp (0.25 deg is the sun's radius), and around the
/// glory.
std::vector<double> scattering_angles() {
  std::vector<double> out = {0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 3.5};
  for (int i = 4; i < 10; ++i) out.push_back(i);
  for (int i = 10; i < 30; i += 2) out.push_back(i);
  for (int i = 30; i < 160; i += 5) out.push_back(i);
  for (int i = 160; i <= 180; i += 2) out.push_back(i);
  return out;
}

std::vector<double> sum_of(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

/// Cosines of the light's travel: sign 1 up, -1 down, never 0.
std::vector<double> cosines(const std::vector<double>& zenith_deg, double sign) {
  std::vector<double> out;
  for (double zenith : zenith_deg) out.push_back(sign * std::max(std::cos(base::rad_by_division(zenith)), 1e-9));
  return out;
}

/// Depths at which a table's rows are taken from a solved column.
struct Depths {
  double sensor, ground;
  std::vector<double> targets, sensor_and_targets;
  Depths(const solver::ColumnSolution& solved, const BinGeometry& g) {
    const auto depth_of = [&](std::size_t level) { return solved.level_depth(g.stack->layers() - level); };
    sensor = depth_of(g.sensor_level), ground = depth_of(0);
    for (std::size_t level : g.level) targets.push_back(depth_of(level));
    sensor_and_targets = targets;
    sensor_and_targets.insert(sensor_and_targets.begin(), sensor);
  }
};

}  // namespace

BinGeometry::BinGeometry(const AirStack& air, const scene::Sun& sun, double z0_km, double sensor_height_m,
                         const std::vector<double>& target_height_m, const std::vector<double>& view_zenith_deg)
    : stack(&air),
      sun_zenith_deg(sun.zenith_deg),
      sun_azimuth_deg(sun.azimuth_deg),
      day(sun.zenith_deg < 90),
      sensor_level(air.level_of(z0_km + sensor_height_m / 1000)),
      view_zenith(view_zenith_deg.empty() ? kViewZenith_deg : view_zenith_deg),
      view_azimuth{0, 5, 10, 15, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150, 160, 170, 180},
      sky_zenith{0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 82.5, 85, 87, 89, 90},
      sky_azimuth{0, 5, 10, 20, 30, 45, 60, 75, 90, 105, 120, 135, 150, 165, 180},
      scattering_angle(scattering_angles()) {
  const std::size_t top = air.layers();
  for (double height : target_height_m) {
    level.push_back(air.level_of(z0_km + height / 1000));
    sun_path.push_back(air.path_factors(level.back(), top, day ? sun_zenith_deg : 0));
    for (double zenith : view_zenith) view_path.push_back(air.path_factors(level.back(), sensor_level, zenith));
    for (double zenith : sky_zenith) sky_path.push_back(air.path_factors(level.back(), top, zenith));
  }
}

BinRows::BinRows(RenderTable& table, const BinGeometry& geometry, bool thermal, LayerEmission emission)
    : table_(table), geometry_(geometry), thermal_(thermal), emission_(emission) {
  add_axis(table, "view_zenith", geometry.view_zenith);
  add_axis(table, "relative_azimuth", geometry.view_azimuth);
  add_axis(table, "sky_zenith", geometry.sky_zenith);
  add_axis(table, "sky_azimuth", geometry.sky_azimuth);
  add_axis(table, "scattering_angle", geometry.scattering_angle);
  const char* bands = "band-model gases by path, Rayleigh, aerosols; spherical refracting shells";
  const char* solver = "discrete ordinates over k-terms";
  for (const char* row : {"sun_transmission", "sun_optical_depth", "view_transmission", "view_optical_depth"})
    add_row(table, row, bands);
  add_row(table, "two_way_factor", "band-model transmission of the joined path over the product of both");
  for (const char* row : {"path_radiance_solar", "sky_radiance_solar", "diffuse_irradiance", "spherical_albedo",
                          "diffuse_view_transmission", "diffuse_return"})
    add_row(table, row, solver);
  add_row(table, "sky_phase_mean", "by scattering depth above the target");
  add_row(table, "sky_scattering_depth", "Rayleigh and aerosol extinction above the target");
  add_row(table, "direct_irradiance", "E0 cos(sun zenith) T_sun");
  if (!thermal) return;
  const char* emitted =
      "band model along the path, Planck radiance across every layer; scattered light by discrete ordinates";
  for (const char* row : {"path_radiance_thermal", "sky_radiance_thermal"}) add_row(table, row, emitted);
  add_row(table, "two_way_factor_thermal", solver);
}

std::span<float> BinRows::row(const char* name, std::size_t i) const {
  std::vector<float>& values = table_.rows.at(name).values;
  const std::size_t size = values.size() / table_.axes.at("wavelength").nodes.size();
  return {values.data() + i * size, size};
}

void BinRows::fill(std::size_t i, const SpectralAir& air, int streams) const {
  fill_paths(i, air);
  fill_scattering(i, air, streams);
  if (thermal_) fill_thermal(i, air, streams);
}

void BinRows::fill_paths(std::size_t i, const SpectralAir& air) const {
  const BinGeometry& g = geometry_;
  const std::size_t heights = g.level.size(), views = g.view_zenith.size(), angles = g.scattering_angle.size();
  float& solar = row("solar_irradiance", i)[0];
  if (!g.day) solar = 0;
  const double e0 = solar, mu0 = g.day ? std::cos(base::rad_by_division(g.sun_zenith_deg)) : 0;
  const auto sun_depth = row("sun_optical_depth", i), sun_transmission = row("sun_transmission", i);
  const auto view_depth = row("view_optical_depth", i), view_transmission = row("view_transmission", i);
  const auto direct = row("direct_irradiance", i), factor = row("two_way_factor", i);
  const auto shape_depth = row("sky_scattering_depth", i), phase = row("sky_phase_mean", i);
  for (std::size_t h = 0; h < heights; ++h) {
    const double sun_lines = air.line_depth(g.sun_path[h]), down = air.grey_depth(g.sun_path[h]) + sun_lines;
    sun_depth[h] = static_cast<float>(down);
    sun_transmission[h] = static_cast<float>(std::exp(-down));
    direct[h] = static_cast<float>(e0 * mu0 * std::exp(-down));
    for (std::size_t v = 0; v < views; ++v) {
      const std::size_t n = h * views + v;
      const std::vector<double>& path = g.view_path[n];
      const double lines = air.line_depth(path), up = air.grey_depth(path) + lines;
      view_depth[n] = static_cast<float>(up);
      view_transmission[n] = static_cast<float>(std::exp(-up));
      const double joined = air.line_depth(sum_of(g.sun_path[h], path));
      // Where no light comes through either way the ratio carries nothing and is bounded.
      factor[n] = static_cast<float>(std::exp(std::min(sun_lines + lines - joined, kLargestFactorLog)));
    }
    shape_depth[h] = static_cast<float>(air.scattering_depth_above(g.level[h]));
    for (std::size_t s = 0; s < angles; ++s)
      phase[h * angles + s] =
          static_cast<float>(air.mean_phase_above(g.level[h], std::cos(base::rad_by_division(g.scattering_angle[s]))));
  }
}

void BinRows::fill_scattering(std::size_t i, const SpectralAir& air, int streams) const {
  const BinGeometry& g = geometry_;
  const std::size_t heights = g.level.size(), views = g.view_zenith.size(), azimuths = g.view_azimuth.size();
  const std::size_t zeniths = g.sky_zenith.size(), sky_azimuths = g.sky_azimuth.size();
  const std::vector<double> view_cosine = cosines(g.view_zenith, 1), sky_cosine = cosines(g.sky_zenith, -1), none;
  const double e0 = row("solar_irradiance", i)[0];
  // The solver counts azimuth from where the beam goes; the table from where the sun is (docs/conventions.md). Sky
  // light towards the observer from the sun's side travels with the beam, light towards a sensor on the sun's side
  // against it.
  std::vector<double> view_turned;
  for (double azimuth : g.view_azimuth) view_turned.push_back(180 - azimuth);
  const auto count = [&](std::size_t extra) { return std::vector<double>(heights * extra, 0.0); };
  std::vector<double> path = count(views * azimuths), sky = count(zeniths * sky_azimuths), diffuse = count(1);
  std::vector<double> albedo = count(1), through = count(views), back = count(zeniths);
  for (std::size_t j = 0; j < air.terms(); ++j) {
    const double weight = air.weight(j);
    const solver::Column column = air.column(j, e0, g.sun_zenith_deg, false);
    const solver::ColumnSolution solved =
        solver::solve_column(column, {.streams = streams, .fourier_tolerance = kFourierTolerance});
    const Depths at(solved, g);
    const std::vector<double> up =
        e0 > 0 ? solved.radiances(at.sensor_and_targets, view_cosine, view_turned, {}) : none;
    const std::vector<double> down = e0 > 0 ? solved.radiances(at.targets, sky_cosine, g.sky_azimuth, {}) : none;
    const std::vector<solver::GroundTransmission> ground = solved.ground_transmissions({at.sensor}, view_cosine),
                                                  returned = solved.ground_transmissions({at.ground}, sky_cosine);
    const solver::GroundCoupling coupling = solved.ground_coupling();
    const double ground_scattering = air.scattering_depth_above(0);
    for (std::size_t v = 0; v < views; ++v) {
      const double mu = view_cosine[v];
      for (std::size_t h = 0; h < heights; ++h) {
        const double between = air.depth_between(j, g.level[h], g.sensor_level);
        const double transmission = std::exp(-between / mu);
        for (std::size_t a = 0; e0 > 0 && a < azimuths; ++a) {
          const double above = up[v * azimuths + a], below = up[((h + 1) * views + v) * azimuths + a];
          path[(h * views + v) * azimuths + a] += weight * std::max(0.0, above - transmission * below);
        }
        // Diffuse light of the ground is known for the lowest ground. From higher ground it is taken as the same share
        // of what the path scatters: 1 - exp(-depth) of the scatterers.
        const double from_ground = air.depth_between(j, 0, g.sensor_level);
        const double share = from_ground > 0 ? std::expm1(-between / mu) / std::expm1(-from_ground / mu) : 1;
        through[h * views + v] += weight * ground[v].diffuse * share;
      }
    }
    for (std::size_t h = 0; h < heights; ++h) {
      const double share = ground_scattering > 0 ? air.scattering_depth_above(g.level[h]) / ground_scattering : 1;
      albedo[h] += weight * coupling.spherical_albedo * share;
      if (e0 > 0) diffuse[h] += weight * solved.fluxes(at.targets[h], {}).diffuse_down;
      for (std::size_t z = 0; z < zeniths; ++z) back[h * zeniths + z] += weight * returned[z].diffuse * share;
    }
    for (std::size_t k = 0; k < down.size(); ++k) sky[k] += weight * down[k];
  }
  const auto store = [&](const char* name, const std::vector<double>& values) {
    std::transform(values.begin(), values.end(), row(name, i).begin(),
                   [](double value) { return static_cast<float>(std::max(0.0, value)); });
  };
  store("path_radiance_solar", path);
  store("sky_radiance_solar", sky);
  store("diffuse_irradiance", diffuse);
  store("spherical_albedo", albedo);
  store("diffuse_view_transmission", through);
  store("diffuse_return", back);
}

void BinRows::fill_thermal(std::size_t i, const SpectralAir& air, int streams) const {
  const BinGeometry& g = geometry_;
  const std::size_t heights = g.level.size(), views = g.view_zenith.size(), zeniths = g.sky_zenith.size();
  const std::size_t top = g.stack->layers();
  const std::vector<double> view_cosine = cosines(g.view_zenith, 1), sky_cosine = cosines(g.sky_zenith, -1);
  const auto count = [&](std::size_t extra) { return std::vector<double>(heights * extra, 0.0); };
  std::vector<double> path = count(views), sky = count(zeniths), joined = count(views), plain_sky = count(1);
  std::vector<double> plain_view = count(views);
  for (std::size_t h = 0; h < heights; ++h) {
    for (std::size_t v = 0; v < views; ++v)
      path[h * views + v] =
          path_emission(air, *g.stack, g.view_path[h * views + v], g.level[h], g.sensor_level, true, emission_);
    for (std::size_t z = 0; z < zeniths; ++z)
      sky[h * zeniths + z] =
          path_emission(air, *g.stack, g.sky_path[h * zeniths + z], g.level[h], top, false, emission_);
  }
  // Thermal light scattered into the path: what the solver has beyond the same column in which scattering only takes
  // away.
  const bool scattered = emission_ == LayerEmission::graded;
  for (std::size_t j = 0; j < air.terms(); ++j) {
    const double weight = air.weight(j);
    const solver::ColumnSolution solved = solver::solve_column(air.column(j, 0, 0, true), {.streams = streams});
    const Depths at(solved, g);
    const std::vector<double> up = solved.radiances(at.sensor_and_targets, view_cosine, {0}, {});
    const std::vector<double> down = solved.radiances(at.targets, sky_cosine, {0}, {});
    for (std::size_t h = 0; h < heights; ++h) {
      const double irradiance = solved.fluxes(at.targets[h], {}).diffuse_down;
      plain_sky[h] += weight * irradiance;
      for (std::size_t v = 0; v < views; ++v) {
        const double mu = view_cosine[v];
        const double transmission = std::exp(-air.depth_between(j, g.level[h], g.sensor_level) / mu);
        joined[h * views + v] += weight * irradiance * transmission;
        plain_view[h * views + v] += weight * transmission;
        if (!scattered) continue;
        const double gained = up[v] - transmission * up[(h + 1) * views + v];
        path[h * views + v] +=
            weight * (gained - term_emission(air, *g.stack, j, mu, g.level[h], g.sensor_level, true));
      }
      for (std::size_t z = 0; scattered && z < zeniths; ++z)
        sky[h * zeniths + z] +=
            weight * (down[h * zeniths + z] - term_emission(air, *g.stack, j, -sky_cosine[z], g.level[h], top, false));
    }
  }
  for (std::size_t k = 0; k < joined.size(); ++k) {
    const double product = plain_sky[k / views] * plain_view[k];
    joined[k] = product > kSmallestTransmission ? joined[k] / product : 1.0;
  }
  const auto store = [&](const char* name, const std::vector<double>& values) {
    std::transform(values.begin(), values.end(), row(name, i).begin(),
                   [](double value) { return static_cast<float>(std::max(0.0, value)); });
  };
  store("path_radiance_thermal", path);
  store("sky_radiance_thermal", sky);
  store("two_way_factor_thermal", joined);
}

}  // namespace raycube::atmos
