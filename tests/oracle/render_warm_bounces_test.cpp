// Thermal light between surfaces: what warm surfaces send onto others, in closed form: one temperature everywhere, the
// corner of two endless half planes by night and by day, a hollow sphere, leaves and plates over ground.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "atmos_tables/synthetic.h"
#include "host/base/planck.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"
#include "tests/support/chance_checks.h"
#include "tests/support/lit_scenes.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace raycube;
using test::check_mean, test::mean_of;
constexpr double kPi = std::numbers::pi, kFar_m = 2e4, kFwhm = 0.05, kSky_K = 235;
const std::vector<double> kCenters = {3.8, 8.6, 10.0, 12.1};

double planck(double l, double kelvin) { return base::planck_radiance(l, kelvin); }
double sky(double l) { return (0.5 + 0.3 * std::sin(3 * l)) * planck(l, kSky_K); }

/// a + b sin(c l), on nodes of 20 nm.
scene::Curve wavy(double a, double b, double c) {
  scene::Curve out;
  for (int i = 0; i <= 600; ++i) {
    out.wavelength_um.push_back(2 + 0.02 * i);
    out.value.push_back(a + b * std::sin(c * out.wavelength_um.back()));
  }
  return out;
}
double at(const scene::Curve& curve, double l) {
  const double x = (l - 2) / 0.02;
  const auto i = static_cast<std::size_t>(x);
  const double f = x - static_cast<double>(i);
  return (1 - f) * curve.value[i] + f * curve.value[i + 1];
}

/// Mean over a band of kFwhm, by Simpson's rule within 2.5 FWHM.
double band_mean(double center, const std::function<double(double)>& f) {
  double sum = 0, norm = 0;
  constexpr int n = 200;
  for (int i = 0; i <= n; ++i) {
    const double x = (2.0 * i / n - 1) * 2.5 * kFwhm;
    const double w = (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * std::exp(-4 * std::numbers::ln2 * x * x / kFwhm / kFwhm);
    sum += w * f(center + x), norm += w;
  }
  return sum / norm;
}

std::uint32_t warm(scene::CompiledScene& scene, const char* name, double kelvin, scene::Curve reflectance) {
  const auto surface = test::add_material(scene, name, 0.5);
  scene.materials.back().reflectance = std::move(reflectance);
  scene.materials.back().temperature_K = kelvin;
  return surface;
}

scene::Simulation seen_by(const scene::Instrument& camera) {
  scene::Simulation simulation;
  simulation.sun.zenith_deg = 120;
  simulation.sky_directions = 64, simulation.bounces_given = true;
  simulation.instruments = {camera};
  simulation.instruments[0].bands = test::gaussian_bands(kCenters, kFwhm);
  simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 4;
  return simulation;
}

/// Under a sky that emits, through air that does nothing; by day sunlight, of this irradiance, too.
test::Image seen(scene::Simulation& simulation, int levels, const std::function<double(double)>& thermal_sky = sky,
                 double sunlight = 0, const render::RenderOptions& options = {}) {
  simulation.bounces = levels;
  atmos::UniformAir air;
  air.solar_irradiance = [=](double) { return sunlight; };
  air.sun_zenith_deg = simulation.sun.zenith_deg, air.sun_azimuth_deg = simulation.sun.azimuth_deg;
  air.thermal_sky_radiance = thermal_sky;
  air.thermal_path_radiance = [](double) { return 0.0; };
  return test::render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(3.5, 12.5, 0.005)), options);
}

struct Matter {
  double kelvin;
  scene::Curve reflectance;
  double emitted(double l) const { return (1 - at(reflectance, l)) * planck(l, kelvin); }
};

/// The ground east of an endless wall, seen 2 to 3 m before it. The wall of 20 km lacks 1.5e-4 of its half.
struct Corner {
  Matter ground{288, wavy(0.4, 0.2, 2)}, wall{340, wavy(0.15, 0.1, 3)};
  scene::Simulation simulation = seen_by(test::nadir_camera(16, 16, 50, 0.05, 2.5, 0));
  Corner() {
    auto& scene = simulation.scene;
    const auto floor = warm(scene, "ground", ground.kelvin, ground.reflectance),
               side = warm(scene, "wall", wall.kelvin, wall.reflectance);
    test::place(scene, test::rectangle({0, -kFar_m, 0}, {kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, floor));
    test::place(scene, test::rectangle({0, -kFar_m, 0}, {0, 2 * kFar_m, 0}, {0, 0, kFar_m}, side));
    finish_top_tree(scene);
  }
  /// Of the ground, where what is met beyond `levels` surfaces counts as the surroundings do. By sun: irradiance of
  /// ground and wall.
  double radiance(double l, int levels, double around_K, double sun_ground = 0, double sun_wall = 0) const {
    const Matter* of[2] = {&ground, &wall};
    const double sun[2] = {sun_ground, sun_wall};
    double met = planck(l, around_K);
    for (int level = levels; level >= 0; --level) {
      const int i = level % 2;
      met = of[i]->emitted(l) + at(of[i]->reflectance, l) * (sun[i] / kPi + (met + sky(l)) / 2);
    }
    return met;
  }
};

}  // namespace

TEST_CASE("S16 warm paths: where all is of one temperature they add neither light nor noise") {
  const double kelvin = 288.15;
  scene::Simulation simulation = seen_by(test::nadir_camera(24, 24, 1000, 1.0));
  auto& scene = simulation.scene;
  const auto dark = warm(scene, "dark", kelvin, wavy(0.02, 0, 1)),
             grey = warm(scene, "grey", kelvin, wavy(0.5, 0.3, 2)),
             mirror = warm(scene, "bright", kelvin, wavy(0.95, 0, 1)),
             pane = warm(scene, "pane", kelvin, wavy(0.1, 0.05, 3)),
             leaf = warm(scene, "leaf", kelvin, wavy(0.2, 0.1, 2));
  scene.materials[3].transmittance = wavy(0.5, 0.2, 4), scene.materials[3].behind = {RC_SHAPE_plate};
  scene.materials[4].transmittance = wavy(0.3, 0.1, 4);
  test::place(scene, test::rectangle({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, grey));
  test::place(scene, test::box({-9, -3, 0}, {-6, 6, 8}, mirror));
  test::place(scene, test::box({-2, 2, 0}, {3, 3, 5}, dark));
  test::place(scene, test::rectangle({2, -8, 0.5}, {6, 0, 3}, {0, 5, 1}, leaf));
  test::place(scene, test::rectangle({-8, -9, 4}, {6, 0, 0}, {0, 5, 0}, pane));
  test::place(scene, test::rectangle({-8, -9, 5}, {6, 0, 0}, {0, 5, 1}, pane));
  finish_top_tree(scene);
  const auto image = seen(simulation, 6, [=](double l) { return planck(l, kelvin); });
  REQUIRE(image.plan.bounces.any());
  CHECK(image.plan.matter.plates);
  std::vector<double> want;
  for (const double l : kCenters) want.push_back(band_mean(l, [=](double at) { return planck(at, kelvin); }));
  const double worst = test::worst_relative(image, want);
  MESSAGE("worst pixel " << worst);
  CHECK(worst < 2e-5);  // lines of 5 nm under Planck's law at 3.8 um: (13 / 3.8 um)^2 (5 nm)^2 / 8 = 4e-5 at most
}

TEST_CASE("S4.8 warm paths: a hot wall and the ground before it, level by level, by night and by day") {
  for (const double sunlight : {0.0, 12.0})
    for (const int levels : {1, 2, 6}) {
      Corner corner;
      const double zenith = 40 * kPi / 180;
      if (sunlight > 0) corner.simulation.sun.zenith_deg = 40, corner.simulation.sun.azimuth_deg = 90;
      const auto image = seen(corner.simulation, levels, sky, sunlight);
      REQUIRE(image.plan.bounces.any());
      const double around_K = image.plan.thermal.surroundings_K;
      CHECK(image.plan.sun_sources == (sunlight > 0 ? 1 : 0));
      for (std::size_t b = 0; b < kCenters.size(); ++b) {
        CAPTURE(sunlight);
        CAPTURE(levels);
        CAPTURE(kCenters[b]);
        const auto light = [&](int surfaces) {
          return band_mean(kCenters[b], [&](double l) {
            return corner.radiance(l, surfaces, around_K, sunlight * std::cos(zenith), sunlight * std::sin(zenith));
          });
        };
        check_mean(mean_of(image, static_cast<int>(b)), light(levels), 1e-3);
        CHECK(std::abs(light(levels) / light(0) - 1) > 0.01);  // else nothing would be tested
      }
      MESSAGE("skeleton of " << image.plan.bounces.skeleton.size() << ", error " << image.plan.bounces.error);
    }
}

TEST_CASE("S16 warm paths: in a hollow sphere of two halves every point gets the mean of what all send") {
  scene::Simulation simulation = seen_by(test::nadir_camera(16, 16, 6, 0.1, 0, 0));
  auto& scene = simulation.scene;
  const Matter cool{280, wavy(0.4, 0.1, 2)}, hot{330, wavy(0.3, 0.2, 3)};
  const auto below = warm(scene, "cool", cool.kelvin, cool.reflectance),
             above = warm(scene, "hot", hot.kelvin, hot.reflectance);
  scene::TriangleMesh sphere = test::sphere(5, 10, 0);
  sphere.surface.clear();
  for (const auto& corner : sphere.triangles) {
    double z = 0;
    for (const auto vertex : corner) z += sphere.vertices[vertex][2];
    sphere.surface.push_back(z < 0 ? below : above);
  }
  append_instance(scene, append_mesh(scene, "sphere", sphere), test::placement(0, 0, 1, 0, 0, 0), 1);
  finish_top_tree(scene);
  const auto image = seen(simulation, 16);
  for (std::size_t b = 0; b < kCenters.size(); ++b) {
    CAPTURE(kCenters[b]);
    check_mean(mean_of(image, static_cast<int>(b)),
               band_mean(kCenters[b],
                         [&](double l) {
                           const double mean = (cool.emitted(l) + hot.emitted(l)) / 2,
                                        back = (at(cool.reflectance, l) + at(hot.reflectance, l)) / 2;
                           return cool.emitted(l) + at(cool.reflectance, l) * mean / (1 - back);
                         }),
               2e-3);
  }
}

TEST_CASE("S23 S24 warm paths: through an endless leaf or plate shows what the ground below it sends") {
  struct Case {
    bool plate, black;  ///< black: the sheet reflects nothing
    double sheet_K;
  };
  for (const auto& [plate, black, sheet_K] :
       {Case{false, false, 270}, Case{true, false, 270}, Case{true, true, 270}, Case{true, false, 600}}) {
    scene::Simulation simulation = seen_by(test::nadir_camera(16, 16, 20, 0.04, 0, 0));
    auto& scene = simulation.scene;
    const Matter ground{320, wavy(0.3, 0.2, 2)}, sheet{sheet_K, black ? wavy(0, 0, 1) : wavy(0.2, 0.1, 3)};
    const scene::Curve let = wavy(0.5, 0.2, 4);
    const auto soil = warm(scene, "ground", ground.kelvin, ground.reflectance),
               glass = warm(scene, "sheet", sheet.kelvin, sheet.reflectance);
    scene.materials[1].transmittance = let;
    if (plate) scene.materials[1].behind = {RC_SHAPE_plate};
    for (const auto& [z, surface] : {std::pair{0.0, soil}, std::pair{2.0, glass}})
      test::place(scene, test::rectangle({-kFar_m, -kFar_m, z}, {2 * kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, surface));
    finish_top_tree(scene);
    simulation.sky_directions = 256;
    const auto image = seen(simulation, 16);
    for (std::size_t b = 0; b < kCenters.size(); ++b) {
      CAPTURE(plate);
      CAPTURE(black);
      CAPTURE(sheet_K);
      CAPTURE(kCenters[b]);
      check_mean(mean_of(image, static_cast<int>(b)),
                 band_mean(kCenters[b],
                           [&](double l) {
                             const double r = at(sheet.reflectance, l), t = at(let, l), rho = at(ground.reflectance, l);
                             const double own = (1 - r - t) * planck(l, sheet.kelvin);
                             const double floor = (ground.emitted(l) + rho * (own + t * sky(l))) / (1 - rho * r);
                             return own + r * sky(l) + t * floor;
                           }),
                 1e-3);
    }
    render::RenderOptions little;
    little.threads = 1, little.tile_lines = 3, little.memory_bytes = std::size_t{32} << 20;
    CHECK(seen(simulation, 16, sky, 0, little).radiance == image.radiance);
  }
}

TEST_CASE("S16 warm paths: what stands for the surroundings does not matter where paths see all that hides the sky") {
  // A plane far below the ground, which nothing sees, turns the mean temperature from 314 K to about 400.
  Corner corner;
  const auto plain = seen(corner.simulation, 24);
  const auto hidden = warm(corner.simulation.scene, "hidden", 480, wavy(0, 0, 1));
  test::place(corner.simulation.scene,
              test::rectangle({-kFar_m, -kFar_m, -100}, {2 * kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, hidden));
  finish_top_tree(corner.simulation.scene);
  corner.simulation.sky_directions = 2048;
  const auto hot = seen(corner.simulation, 24);
  CHECK(hot.plan.thermal.surroundings_K > plain.plan.thermal.surroundings_K + 50);
  for (int b = 0; b < static_cast<int>(kCenters.size()); ++b) {
    CAPTURE(b);
    const auto one = mean_of(plain, b), other = mean_of(hot, b);
    CHECK_WITHIN(one.value - other.value, 4.5 * std::hypot(one.error, other.error) + 2e-3 * one.value);
    CHECK_BELOW(other.error, 0.02 * one.value);
  }
}

TEST_CASE("S16 warm paths: matter that no surface has changes no bit of them, whatever its lobes") {
  Corner corner;
  const auto plain = seen(corner.simulation, 4);
  test::add_material(corner.simulation.scene, "unused", 0.3);
  auto& unused = corner.simulation.scene.materials.back();
  unused.front_nodes = {{0.5, {RC_SHAPE_oren_nayar, {60, 0}}}, {0.9, {RC_SHAPE_oren_nayar, {10, 0}}}};
  unused.front = unused.front_nodes[0].shape;
  scene::make_lobes(unused);
  finish_top_tree(corner.simulation.scene);
  CHECK(seen(corner.simulation, 4).radiance == plain.radiance);
}
