// Stability of the layered model where atmospheres fail (REQUIREMENTS section 4, "Volumes and atmosphere"): every table
// is finite, keeps its limits (validate) and obeys the law or the limit named.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "host/base/error.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

scene::AtmosphereSpec air() {
  scene::AtmosphereSpec spec;
  spec.layered.emplace();
  return spec;
}

scene::Sun sun_at(double zenith_deg) {
  scene::Sun sun;
  sun.zenith_deg = zenith_deg;
  return sun;
}

/// A cloud of the whole sky from 1 to 2 km.
scene::AtmosphereSpec overcast(double depth) {
  auto spec = air();
  spec.layered->clouds.push_back({"stratus", 1, 2, depth});
  return spec;
}

void all_finite(const RenderTable& table) {
  for (const auto& [name, row] : table.rows) {
    CAPTURE(name);
    bool finite = true;
    for (float value : row.values) finite = finite && std::isfinite(value);
    CHECK(finite);
  }
}

double relative(double a, double b) { return std::abs(a / b - 1); }

}  // namespace

TEST_CASE("stability: optical depth 0, 1e-6, 1 and 700 of a cloud") {
  const std::vector<double> grid = {0.55};
  const RenderTable clear = build_layered(air(), sun_at(40), 3000, grid, {0});
  const RenderTable none = build_layered(overcast(0), sun_at(40), 3000, grid, {0});
  const RenderTable thin = build_layered(overcast(1e-6), sun_at(40), 3000, grid, {0});
  const RenderTable one = build_layered(overcast(1), sun_at(40), 3000, grid, {0});
  const RenderTable thick = build_layered(overcast(700), sun_at(40), 3000, grid, {0});
  for (const RenderTable* table : {&none, &thin, &one, &thick}) all_finite(*table);
  // No cloud and a cloud of nothing are one air (levels at 1 and 2 km are there already); 1e-6 changes by about 1e-6.
  CHECK(relative(diffuse_irradiance(none, 0)[0], diffuse_irradiance(clear, 0)[0]) < 1e-6);
  CHECK(relative(diffuse_irradiance(thin, 0)[0], diffuse_irradiance(clear, 0)[0]) < 1e-4);
  CHECK(relative(sun_transmission(thin, 0)[0], sun_transmission(clear, 0)[0]) < 3e-6);
  // Beer's law through the cloud, the sun at 40 deg.
  CHECK(sun_transmission(one, 0)[0] / sun_transmission(clear, 0)[0] ==
        doctest::Approx(std::exp(-1 / std::cos(40 * std::numbers::pi / 180))).epsilon(0.002));
  CHECK(sun_transmission(thick, 0)[0] == 0);
  // Diffusion: a nearly conservative cloud of depth 700 lets about 4/3 / (1 + 0.75 (1 - g) tau) of the light through, g
  // 0.86.
  const double through =
      diffuse_irradiance(thick, 0)[0] / (solar_irradiance(thick)[0] * std::cos(40 * std::numbers::pi / 180));
  CHECK(through > 0);
  CHECK(through < 0.03);
  // What comes down from below is what went up: a thick cloud returns nearly all.
  CHECK(spherical_albedo(thick, 0)[0] > 0.9);
  CHECK(spherical_albedo(thick, 0)[0] <= 1);
}

TEST_CASE("stability: single-scattering albedo exactly 1, nothing is lost") {
  // No aerosol, no gas absorption worth naming at 0.45 um but ozone's 1e-3: what the ground gets and what the air
  // returns to space is the light that came; checked as direct + diffuse + up = E0 mu0 through the albedo of the
  // column.
  auto spec = air();
  spec.layered->aerosol = "none";
  spec.layered->ozone_atm_cm = 0;
  const RenderTable table = build_layered(spec, sun_at(30), 2e5, {0.45}, {0});
  all_finite(table);
  double up = 0;  // irradiance at the top: path radiance seen from above, cosine weighted
  constexpr int kZenith = 40, kAzimuth = 24;
  for (int i = 0; i < kZenith; ++i) {
    const double zenith = std::acos(std::sqrt((i + 0.5) / kZenith)) * 180 / std::numbers::pi;
    for (int a = 0; a < kAzimuth; ++a)
      up += path_radiance(table, 0, std::min(zenith, 80.0), 180 * (a + 0.5) / kAzimuth)[0] * std::numbers::pi /
            (kZenith * kAzimuth);
  }
  const double in = solar_irradiance(table)[0] * std::cos(30 * std::numbers::pi / 180);
  // Views end at 80 deg (the last 3 % of the hemisphere taken as there): 1 %.
  CHECK(direct_irradiance(table, 0)[0] + diffuse_irradiance(table, 0)[0] + up == doctest::Approx(in).epsilon(0.01));
}

TEST_CASE("stability: sun at the horizon, in twilight and below") {
  const RenderTable low = build_layered(air(), sun_at(89.9), 1000, {0.55, 0.8}, {0});
  all_finite(low);
  CHECK(sun_transmission(low, 0)[0] > 0);
  CHECK(sun_transmission(low, 0)[0] < 0.05);
  CHECK(diffuse_irradiance(low, 0)[0] > 0);
  for (double zenith : {90.0, 95.0, 107.9, 108.0, 180.0}) {
    const RenderTable night = build_layered(air(), sun_at(zenith), 1000, {0.55}, {0});
    all_finite(night);
    CHECK(diffuse_irradiance(night, 0)[0] == 0);
    CHECK(path_radiance(night, 0, 30, 60)[0] == 0);
  }
}

TEST_CASE("stability: sun exactly at a quadrature node and overhead") {
  // Double-Gauss node of 16 streams: 0.591717 -> 53.72 deg; the sun there and around it gives one smooth curve.
  const double node_deg = std::acos(0.5917173212478249) * 180 / std::numbers::pi;
  double at[3];
  int k = 0;
  for (double zenith : {node_deg - 0.01, node_deg, node_deg + 0.01})
    at[k++] = diffuse_irradiance(build_layered(air(), sun_at(zenith), 1000, {0.5}, {0}), 0)[0];
  CHECK(std::abs(at[1] - 0.5 * (at[0] + at[2])) < 1e-6 * at[1]);
  const RenderTable overhead = build_layered(air(), sun_at(0), 1000, {0.5}, {0});
  all_finite(overhead);
  // No azimuth is special under an overhead sun.
  CHECK(sky_radiance(overhead, 0, 50, 10)[0] == doctest::Approx(sky_radiance(overhead, 0, 50, 170)[0]).epsilon(1e-6));
}

TEST_CASE("stability: view at the horizon") {
  const RenderTable table = build_layered(air(), sun_at(40), 1000, {0.55, 10.0}, {0});
  for (double azimuth : {0.0, 90.0, 180.0}) {
    CHECK(std::isfinite(sky_radiance(table, 0, 90, azimuth)[0]));
    CHECK(sky_radiance(table, 0, 90, azimuth)[0] > 0);
  }
  // Towards the horizon the air is opaque at 10 um: the sky there is warmer than overhead.
  CHECK(sky_radiance_thermal(table, 0, 90)[1] > sky_radiance_thermal(table, 0, 0)[1]);
  // Views of the ground end at 80 deg: beyond them is an error that says so, not a guess.
  CHECK_THROWS_AS(path_radiance(table, 0, 89.5, 0), base::Error);
}

TEST_CASE("stability: sensor on the ground, inside and above the air; target at and above the sensor") {
  const RenderTable ground = build_layered(air(), sun_at(40), 0, {0.55}, {0});
  all_finite(ground);
  CHECK(view_transmission(ground, 0, 30)[0] == doctest::Approx(1).epsilon(1e-6));
  CHECK(path_radiance(ground, 0, 30, 0)[0] == doctest::Approx(0).epsilon(1e-9));
  const RenderTable inside = build_layered(air(), sun_at(40), 5000, {0.55}, {0, 5000});
  const RenderTable top = build_layered(air(), sun_at(40), 1e5, {0.55}, {0});
  const RenderTable space = build_layered(air(), sun_at(40), 8e8, {0.55}, {0});
  CHECK(path_radiance(inside, 0, 0, 0)[0] < path_radiance(space, 0, 0, 0)[0]);
  CHECK(view_transmission(inside, 0, 0)[0] > view_transmission(space, 0, 0)[0]);
  // Past 100 km there is no air: the same light from any height.
  CHECK(path_radiance(top, 0, 30, 0)[0] == doctest::Approx(path_radiance(space, 0, 30, 0)[0]).epsilon(1e-6));
  CHECK_THROWS_AS(build_layered(air(), sun_at(40), 5000, {0.55}, {0, 5001}), base::Error);
}
