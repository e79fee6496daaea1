// Light between ground and air (S4.9) through the whole chain, against closed forms with tables whose rows the test
// states:
//   L = L0 + [rho_t T_dir + rho_e T_dif] E_g0 / (pi (1 - rho_m S)),   L_sky = L_sky0 + rho_m E_g0 / (pi (1 - rho_m S))
//   t
// with rho_t under the pixel, rho_e in its environment, rho_m the scene's mean. Flat ground, framing camera straight
// above.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/environment_function.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;

/// Air of one node everywhere with ground coupling; S = t as 2 int t mu dmu has it.
atmos::UniformAir coupled_air(double albedo_of_air, double t_dif) {
  scene::Sun sun;
  sun.zenith_deg = 40, sun.azimuth_deg = 0;
  atmos::UniformAir air = test::uniform_air({1500, 0.75, 0.625, 1, 40, 6}, sun);
  air.spherical_albedo = air.diffuse_return = [=](double) { return albedo_of_air; };
  air.diffuse_view_transmission = [=](double) { return t_dif; };
  air.sensor_height_m = 600;
  return air;
}
double sun_and_sky() { return 1500 * 0.75 * std::cos(40 * kPi / 180) + kPi * 40; }

const std::vector<double>& grid() {
  static const std::vector<double> list = atmos::wavelength_grid(0.4, 1.0, 0.01);
  return list;
}

/// A square of `inside` reflectance, side `side` m (0: none), centred in 4 km x 4 km of `outside`.
scene::Simulation ground(double outside, double inside = 0, double side = 0) {
  scene::Simulation simulation;
  const auto field = test::add_material(simulation.scene, "field", outside);
  if (side == 0) {
    test::place(simulation.scene, test::rectangle({-2000, -2000, 0}, {4000, 0, 0}, {0, 4000, 0}, field));
  } else {
    const auto target = test::add_material(simulation.scene, "target", inside);
    const double h = side / 2, w = 2000 - h;
    test::place(simulation.scene, test::join({test::rectangle({-h, -h, 0}, {side, 0, 0}, {0, side, 0}, target),
                                              test::rectangle({-2000, -2000, 0}, {4000, 0, 0}, {0, w, 0}, field),
                                              test::rectangle({-2000, h, 0}, {4000, 0, 0}, {0, w, 0}, field),
                                              test::rectangle({-2000, -h, 0}, {w, 0, 0}, {0, side, 0}, field),
                                              test::rectangle({h, -h, 0}, {w, 0, 0}, {0, side, 0}, field)}));
  }
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 40;
  simulation.instruments = {test::nadir_camera(4, 3, 600, 1.0)};
  return simulation;
}

double worst_against(const test::Image& image, double expected) {
  double worst = 0;
  for (const float l : image.radiance) worst = std::max(worst, std::abs(l / expected - 1));
  return worst;
}

/// Share of the environment function inside a centred square, seen from a point within it: one integral over azimuth.
double share_in_square(atmos::Scatterer scatterer, double x_m, double y_m, double side_m, double height_m) {
  constexpr int n = 20000;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * kPi * (i + 0.5) / n, dx = std::cos(a), dy = std::sin(a);
    const double r =
        std::min(((dx > 0 ? side_m / 2 : -side_m / 2) - x_m) / dx, ((dy > 0 ? side_m / 2 : -side_m / 2) - y_m) / dy);
    sum += atmos::environment_function(scatterer, r / 1000, height_m / 1000, 1) / n;
  }
  return sum;
}

}  // namespace

TEST_CASE("S4.9 uniform ground of albedo r: L0 + r (T_dir + T_dif) E_g0 / (pi (1 - r S)) to 1e-5") {
  double worst = 0;
  for (const auto& [albedo_of_air, rs] :
       std::vector<std::pair<double, std::vector<double>>>{{0.0, {1.0}}, {0.25, {0.0, 0.05}}, {0.96875, {0.4, 1.0}}})
    for (const double r : rs) {
      const auto image = test::render_image(ground(r), atmos::uniform_table(coupled_air(albedo_of_air, 0.25), grid()));
      const double rho = r;
      worst = std::max(
          worst, worst_against(image, 6 + rho * (0.625 + 0.25) * sun_and_sky() / (kPi * (1 - rho * albedo_of_air))));
      CHECK(image.plan.environment.nodes() == 1);
    }
  MESSAGE("largest relative error " << worst);
  CHECK(worst < 1e-5);
}

TEST_CASE("S4.9 S16 white furnace: white ground under air that loses nothing shows radiance 1, whatever S") {
  // The sky of radiance 1 is 1 - S from above and S from the ground; T_dir + T_dif = 1, no light in the path otherwise.
  double worst = 0;
  for (const double s : {0.5, 0.998046875}) {
    atmos::UniformAir air = coupled_air(s, 0.375);
    air.solar_irradiance = air.path_radiance = [](double) { return 0.0; };
    air.sky_radiance = [=](double) { return 1 - s; };
    worst = std::max(worst, worst_against(test::render_image(ground(1), atmos::uniform_table(air, grid())), 1));
  }
  MESSAGE("largest error " << worst);
  CHECK(worst < 1e-5);
}

TEST_CASE("S4.9 the modes: off is the table without the rows, bit for bit; mean and local agree on uniform ground") {
  auto simulation = ground(0.3);
  atmos::UniformAir air = coupled_air(0.25, 0.25);
  const auto table = atmos::uniform_table(air, grid());
  air.spherical_albedo = air.diffuse_return = air.diffuse_view_transmission = {};
  const auto plain = atmos::uniform_table(air, grid());
  const auto image_of = [&](scene::Adjacency mode, const atmos::RenderTable& t) {
    simulation.atmosphere.adjacency = mode;
    return test::render_image(simulation, t);
  };
  const auto off = image_of(scene::Adjacency::off, table), without = image_of(scene::Adjacency::automatic, plain);
  REQUIRE(off.radiance.size() == without.radiance.size());
  CHECK(std::memcmp(off.radiance.data(), without.radiance.data(), off.radiance.size() * sizeof(float)) == 0);
  CHECK(plan::ground_mode(off.plan) == "off");
  const auto local = image_of(scene::Adjacency::local, table), mean = image_of(scene::Adjacency::mean, table),
             chosen = image_of(scene::Adjacency::automatic, table);
  CHECK(local.radiance == mean.radiance);
  CHECK(local.radiance == chosen.radiance);
  CHECK(local.at(0, 0, 0) > 1.3f * off.at(0, 0, 0));
  CHECK(plan::ground_mode(chosen.plan) == "local");
  for (const auto mode : {scene::Adjacency::local, scene::Adjacency::mean}) {
    simulation.atmosphere.adjacency = mode;
    CHECK_THROWS_WITH_AS(test::render_image(simulation, plain), doctest::Contains("lacks one of spherical_albedo"),
                         base::Error);
  }
  simulation.atmosphere.adjacency = scene::Adjacency::automatic;
  simulation.scene.materials[0].reflectance.value = {1, 1};
  CHECK_THROWS_WITH_AS(test::render_image(simulation, atmos::uniform_table(coupled_air(1, 0.25), grid())),
                       doctest::Contains("reaches 1"), base::Error);
}

TEST_CASE("S4.9 target in a field: the environment equals direct integration of the environment functions") {
  const double target = 0.1, field = 0.5, s = 0.1, t_dif = 0.2, height = 600;
  double worst = 0;
  for (const double side : {8.0, 60.0, 300.0}) {
    auto simulation = ground(field, target, side);
    const auto table = atmos::uniform_table(coupled_air(s, t_dif), grid());
    const auto image = test::render_image(simulation, table);
    const double share = side * side / (4e6 * 4);  // of the mean, if the coarse raster sees it
    MESSAGE("map " << image.plan.environment.columns << " x " << image.plan.environment.rows << ", step "
                   << image.plan.environment.step_m << " m, mean of the target " << image.plan.environment.mean[1]
                   << " (area " << share << ")");
    const double mean = field + (target - field) * image.plan.environment.mean[1];
    const double up = sun_and_sky() / (kPi * (1 - mean * s));
    for (int pixel = 0; pixel < 4; ++pixel)
      for (int band = 0; band < 3; ++band) {
        const double x = pixel - 1.5, y = 0;  // the middle line
        const double um = simulation.instruments[0].bands[band].center_um;
        const double molecules = std::min(
            1.0, atmos::molecular_diffuse_transmission(um, simulation.atmosphere.pressure_hPa, 0, height, 1) / t_dif);
        const double inside = molecules * share_in_square(atmos::Scatterer::molecules, x, y, side, height) +
                              (1 - molecules) * share_in_square(atmos::Scatterer::aerosol, x, y, side, height);
        const double around = field + (target - field) * inside;
        const double expected = 6 + (target * 0.625 + around * t_dif) * up;
        const double found = ((image.at(1, pixel, band) - 6) / up - target * 0.625) / t_dif;
        if (pixel == 1)
          MESSAGE("side " << side << " m, " << um << " um: environment " << around << ", found " << found
                          << ", radiance off by " << image.at(1, pixel, band) / expected - 1);
        const double error = std::abs(image.at(1, pixel, band) / expected - 1);
        worst = std::max(worst, error);
        // A node speaks for its cell of 9.4 m: of the light that a target of 8 m sends itself, F(4 m) = 3 %, half is
        // the field's.
        CHECK(error < (side < 9.4 ? 8e-3 : 3e-3));
      }
  }
  MESSAGE("largest error of radiance " << worst);
}

TEST_CASE("S4.9 checkerboard of two materials, finer than the air's reach: each tile shows itself and the mean") {
  const double dark = 0.1, bright = 0.7, s = 0.2, t_dif = 0.25, tile = 4;
  scene::Simulation simulation;
  const std::uint32_t material[2] = {test::add_material(simulation.scene, "dark", dark),
                                     test::add_material(simulation.scene, "bright", bright)};
  std::vector<scene::TriangleMesh> tiles;
  for (int i = -30; i < 30; ++i)
    for (int j = -30; j < 30; ++j)
      tiles.push_back(test::rectangle({i * tile, j * tile, 0}, {tile, 0, 0}, {0, tile, 0}, material[(i + j) & 1]));
  test::place(simulation.scene, test::join(tiles));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 40;
  simulation.instruments = {test::nadir_camera(8, 8, 600, tile)};
  const auto image = test::render_image(simulation, atmos::uniform_table(coupled_air(s, t_dif), grid()));
  const double mean = (dark + bright) / 2, up = sun_and_sky() / (kPi * (1 - mean * s));
  double worst = 0;
  for (int line = 0; line < 8; ++line)
    for (int pixel = 0; pixel < 8; ++pixel) {
      // Nodes every 19 m beat against tiles of 4 m: the nearest tile alone holds F(2 m) = 1.5 % of the aerosol's light.
      const double own = image.layer(line, pixel, image.layers - 1) > 0.5 ? bright : dark;
      for (int band = 0; band < 3; ++band)
        worst = std::max(worst, std::abs(image.at(line, pixel, band) / (6 + (own * 0.625 + mean * t_dif) * up) - 1));
    }
  MESSAGE("largest relative error " << worst << ", mean of bright " << image.plan.environment.mean[1]);
  CHECK(std::abs(image.plan.environment.mean[1] - 0.5) < 0.01);
  CHECK(worst < 1e-2);
}

TEST_CASE("S4.9 a ray that misses the scene still sees what the ground around sends up") {
  auto simulation = ground(0.4);
  simulation.instruments = {test::nadir_camera(4, 1, 600, 1.0, 5000, 0)};  // a kilometre outside
  const auto image = test::render_image(simulation, atmos::uniform_table(coupled_air(0.25, 0.25), grid()));
  CHECK(worst_against(image, 6.0) < 1e-6);  // no ground within sight: nothing is known of it, black
  // A raster of the ground that reaches into the view's surroundings: the scene's mean.
  simulation.instruments = {test::nadir_camera(4, 1, 600, 1.0, 2050, 0)};
  const auto near = test::render_image(simulation, atmos::uniform_table(coupled_air(0.25, 0.25), grid()));
  CHECK(worst_against(near, 6 + 0.4 * 0.25 * sun_and_sky() / (kPi * (1 - 0.4 * 0.25))) < 1e-5);
}
