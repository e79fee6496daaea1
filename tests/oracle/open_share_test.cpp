// What a surface takes for granted of the open sky: it must not move a radiance, whatever it is, and it is measured as
// the sky that the surface's points see.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "host/base/planck.h"
#include "host/plan/sky_rays.h"
#include "host/planner/open_share.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

using namespace raycube;

namespace {

constexpr double kSkyRadiance = 30, kReflectance = 0.4;

/// Level ground of one material before a wall of another, 24 x 24 pixels of 1 m before the wall.
scene::Simulation before_wall(double kelvin = 0) {
  scene::Simulation s;
  s.file = "wall.toml";
  for (const char* name : {"ground", "wall"}) {
    test::add_material(s.scene, name, kReflectance);
    s.scene.materials.back().reflectance = {{0.3, 20.0}, {kReflectance, kReflectance}};
    s.scene.materials.back().temperature_K = kelvin;
  }
  test::place(s.scene, test::rectangle({0, -400, 0}, {400, 0, 0}, {0, 800, 0}, 0));
  test::place(s.scene, test::rectangle({0, -400, 0}, {0, 800, 0}, {0, 0, 20}, 1));
  finish_top_tree(s.scene);
  s.sky_directions = 64;
  auto camera = test::nadir_camera(24, 24, 1000, 1.0, 13, 0);
  camera.samples_u = camera.samples_v = 4;
  s.instruments = {camera};
  return s;
}

double mean_of(const test::Image& image) {
  double sum = 0;
  for (const float value : image.radiance) sum += static_cast<double>(value);
  return sum / static_cast<double>(image.radiance.size());
}

}  // namespace

TEST_CASE("S16 ground before a wall: any share taken for granted gives the same mean, none of it a bias") {
  auto s = before_wall();
  s.instruments[0].bands = test::gaussian_bands({0.5}, 0.02);
  const auto table = atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0});
  std::vector<double> means;
  for (const float share : {0.0f, 0.4f, 1.0f}) {
    const auto image = test::render_image(s, table, {}, [&](plan::Plan& plan) {
      plan.sky.open_share.assign(s.scene.surfaces.size(), share);
      plan.sky.cosine_share = 0.5;  // so that rays of an even sky differ
    });
    double square = 0, sum = 0;
    int count = 0;
    for (int line = 0; line < image.lines; ++line)
      for (int pixel = 0; pixel < image.pixels; ++pixel) {
        const double x = pixel + 1.5, slant = std::hypot(x, 20.0);  // columns from the wall outwards
        // Howell, configuration factor B-4, a wall without end: it hides (1 - x / slant) / 2.
        const double want = kReflectance * kSkyRadiance * (1 - (1 - x / slant) / 2);
        const double off = image.at(line, pixel, 0) / want - 1;
        sum += off, square += off * off, ++count;
      }
    const double mean = sum / count, error = std::sqrt(std::max(0.0, square / count - mean * mean) / count);
    MESSAGE("share " << share << ": mean " << mean << " +- " << error << ", of a pixel " << std::sqrt(square / count));
    // The wall ends 400 m to either side and the mean over a pixel of 1 m differs from its middle's: 2e-3.
    CHECK_WITHIN(mean, 4 * error + 2e-3);
    means.push_back(mean_of(image));
  }
}

TEST_CASE("S60 other draws of one seed change the sky's rays and nothing else") {
  auto s = before_wall();
  s.instruments[0].bands = test::gaussian_bands({0.5}, 0.02);
  s.sun.zenith_deg = 40, s.sun.azimuth_deg = 270;  // behind the wall, whose shadow ends among the pixels
  s.instruments[0].sampler = scene::SamplerKind::lattice;
  render::Renderer renderer(s.scene, {});
  const auto drawn = [&](double sky_radiance) {
    const auto table =
        atmos::uniform_sky_table(1000, sky_radiance, {0.3, 1.0, 4.0}, s.sun.zenith_deg, s.sun.azimuth_deg);
    const auto plan = plan::make_plan(s, s.instruments[0], table, sensors::view_bounds(s.instruments[0]));
    return renderer.draws_of(s.instruments[0], plan, s.sun, {{1, 0}, {1, 0}, {1, 1}, {2, 0}}, {{0, 24, 0, 24}});
  };
  const auto lit = drawn(kSkyRadiance), dark = drawn(0);
  CHECK(lit[0] == lit[1]);
  CHECK(lit[0] != lit[2]);
  CHECK(dark[0] == dark[2]);  // samples and sun are those of the seed
  CHECK(dark[0] != dark[3]);
}

TEST_CASE("S16 isothermal: sky, walls and ground of one temperature show it whatever is taken for granted") {
  const double kelvin = 288.15;
  auto s = before_wall(kelvin);
  s.sun.zenith_deg = 120;
  s.instruments[0].bands = test::gaussian_bands({8.5, 10.5}, 0.2);
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return 0.0; };
  air.sun_zenith_deg = 120;
  air.thermal_sky_radiance = [&](double l) { return base::planck_radiance(l, kelvin); };
  air.thermal_path_radiance = [](double) { return 0.0; };
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(7, 14, 0.005));
  for (const float share : {0.0f, 0.3f, 1.0f}) {
    const auto image = test::render_image(
        s, table, {}, [&](plan::Plan& plan) { plan.sky.open_share.assign(s.scene.surfaces.size(), share); });
    for (int b = 0; b < image.bands; ++b) {
      double least = 1e9, most = 0;
      for (int p = 0; p < image.lines * image.pixels; ++p) {
        const double value = static_cast<double>(image.radiance[static_cast<std::size_t>(p * image.bands + b)]);
        least = std::min(least, value), most = std::max(most, value);
      }
      const double want = base::planck_radiance(b == 0 ? 8.5 : 10.5, kelvin);
      CHECK(most / least - 1 < 3e-6);
      CHECK(std::abs(most / want - 1) < 2e-3);  // a band is 0.2 um wide, over which B bends
    }
  }
}

TEST_CASE("tiles that are rendered together say what each says alone, bit for bit") {
  auto s = before_wall();
  s.instruments[0].pixels = 22;  // the last group of a line brings two pixels past its end
  s.instruments[0].bands = test::gaussian_bands({0.5}, 0.02);
  const auto& camera = s.instruments[0];
  const auto table = atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0});
  const plan::Plan plan = plan::make_plan(s, camera, table, sensors::view_bounds(camera));
  const std::vector<render::Tile> tiles = {{0, 1, 0, 8}, {3, 1, 16, 6}, {5, 3, 0, 22}, {3, 1, 8, 8}, {23, 1, 20, 2}};
  std::vector<render::PixelProbe> alone, together;
  render::Renderer renderer(s.scene, {});
  renderer.probe(camera, plan, s.sun, 7, tiles, [&](const auto& probe) { alone.push_back(probe); });
  renderer.probe_together(camera, plan, s.sun, 7, tiles, [&](const auto& probe) { together.push_back(probe); });
  REQUIRE(together.size() == alone.size());
  const auto same_bits = [](const std::vector<float>& a, const std::vector<float>& b) {  // some truth is no number
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
  };
  for (std::size_t i = 0; i < alone.size(); ++i) {
    const auto &a = alone[i], &b = together[i];
    CHECK((b.tile.first_line == tiles[i].first_line && b.tile.first_column == tiles[i].first_column));
    CHECK((a.samples == b.samples && a.sides == b.sides && a.groups.size() == b.groups.size()));
    CHECK((a.hit_instance == b.hit_instance && a.hit_primitive == b.hit_primitive && a.sun_visible == b.sun_visible));
    CHECK(a.radiance.size() == b.tile.pixels() * camera.bands.size());
    CHECK(same_bits(a.radiance, b.radiance));
    CHECK(same_bits(a.sky_met, b.sky_met));
    CHECK(same_bits(a.truth, b.truth));
  }
}

TEST_CASE("open shares: all where nothing hides the sky, none under a roof, of a street what the closed form has") {
  scene::Simulation s;
  s.file = "street.toml";
  for (const char* name : {"open", "roofed", "roof", "street", "walls"})
    test::add_material(s.scene, name, kReflectance);
  test::place(s.scene, test::rectangle({-40, -40, 0}, {30, 0, 0}, {0, 80, 0}, 0));
  test::place(s.scene, test::rectangle({30, -40, 0}, {20, 0, 0}, {0, 80, 0}, 1));
  test::place(s.scene, test::rectangle({-5, -900, -20}, {20, 0, 0}, {0, 1800, 0}, 3));
  for (const double x : {-5.0, 15.0})
    test::place(s.scene, test::rectangle({x, -900, -20}, {0, 1800, 0}, {0, 0, 20}, 4));
  finish_top_tree(s.scene);
  s.sun.zenith_deg = 40, s.sun.azimuth_deg = 160;
  auto camera = test::nadir_camera(64, 64, 1000, 1.2);
  camera.samples_u = camera.samples_v = 8;
  camera.bands = test::gaussian_bands({0.45, 0.55, 0.85}, 0.02);
  s.instruments = {camera};
  const auto table = atmos::build_clear_sky(s.atmosphere, s.sun, 1000, atmos::clear_sky_wavelengths(0.4, 0.95, 0.01),
                                            atmos::clear_sky_heights(-20, 20));
  plan::Plan plan = plan::make_plan(s, camera, table, sensors::view_bounds(camera));
  CHECK(plan.sky.cosine_share >= plan::kLeastCosineShare);
  render::Renderer renderer(s.scene, {});
  planner::measure_open_share(renderer, s, camera, plan);
  REQUIRE(plan.sky.open_share.size() == s.scene.surfaces.size());
  MESSAGE("open " << plan.sky.known(0) << ", street " << plan.sky.known(3));
  CHECK(plan.sky.known(0) > 0.98f);
  // A street without end, 20 m wide and deep, under an even sky: sqrt(1 + (h/w)^2) - h/w = 0.414 (Hottel's crossed
  // strings). This sky is brighter towards the sun and the horizon: a tenth.
  CHECK(std::abs(static_cast<double>(plan.sky.known(3)) - 0.414) < 0.1);

  // An even sky takes the cosine alone.
  const plan::Plan even = plan::make_plan(
      s, camera, atmos::uniform_sky_table(40, kSkyRadiance, {0.4, 0.7, 0.95}, 40, 160), sensors::view_bounds(camera));
  CHECK(even.sky.cosine_share == 1);
}

TEST_CASE("open shares: all of it where nothing hides the surroundings' place in a sky without any light") {
  scene::Simulation s;
  s.file = "roof.toml";
  test::add_material(s.scene, "roof", kReflectance);
  s.scene.materials.back().reflectance = {{0.3, 20.0}, {kReflectance, kReflectance}};
  s.scene.materials.back().temperature_K = 300;
  test::place(s.scene, test::rectangle({-40, -40, -40}, {80, 0, 80}, {0, 80, 0}, 0));  // 45 degrees
  finish_top_tree(s.scene);
  s.sun.zenith_deg = 120;
  auto camera = test::nadir_camera(16, 16, 1000, 1.0);
  camera.samples_u = camera.samples_v = 4;
  camera.bands = test::gaussian_bands({9.0}, 0.2);
  s.instruments = {camera};
  atmos::UniformAir air;
  air.sun_zenith_deg = 120;
  for (auto* spectrum : {&air.solar_irradiance, &air.thermal_sky_radiance, &air.thermal_path_radiance})
    *spectrum = [](double) { return 0.0; };
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(7, 14, 0.005));
  plan::Plan plan = plan::make_plan(s, camera, table, sensors::view_bounds(camera));
  REQUIRE(plan.components() == 1);  // the surroundings
  render::Renderer renderer(s.scene, {});
  planner::measure_open_share(renderer, s, camera, plan);
  CHECK(plan.sky.known(0) == 1.0f);
}
