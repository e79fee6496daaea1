// Plates seen by cameras (S23): light goes straight on through them, to the viewer, from the sun and from the sky, and
// each multiplies it by its transmittance. Oracles: closed forms of endless planes, in four bands of curves that bend.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "host/render/truth.h"
#include "scene_compiler/matter.h"
#include "tests/support/chance_checks.h"
#include "tests/support/lit_scenes.h"

namespace {

using namespace raycube;
using test::at, test::check_mean, test::kCentres, test::kSunIrradiance, test::lit, test::mean_of, test::wavy;
constexpr double kPi = std::numbers::pi, kSkyRadiance = 30, kFar_m = 2e4, kZenith_deg = 40;

/// Level ground below plates that lie over each other, 1 m apart, from `begin_m` in the east on.
struct Glazed {
  scene::Simulation simulation;
  scene::Curve ground = wavy(0.45, 0.3, 9), let = wavy(0.6, 0.25, 14), sent;
  Glazed(int plates, double plate_reflectance, double begin_m = -kFar_m) : sent(wavy(plate_reflectance, 0, 1)) {
    auto& scene = simulation.scene;
    const auto soil = test::add_material(scene, "ground", 0.5), glass = test::add_material(scene, "glass", 0.0);
    scene.materials[0].reflectance = ground;
    scene.materials[1].reflectance = sent, scene.materials[1].transmittance = let;
    scene.materials[1].behind = {RC_SHAPE_plate};
    test::place(scene, test::rectangle({-kFar_m, -kFar_m, 0}, {2 * kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, soil));
    for (int i = 0; i < plates; ++i)
      test::place(scene,
                  test::rectangle({begin_m, -kFar_m, 2.0 + i}, {kFar_m - begin_m, 0, 0}, {0, 2 * kFar_m, 0}, glass));
    finish_top_tree(scene);
    simulation.sky_directions = 64, simulation.bounces_given = true;
    auto camera = test::nadir_camera(16, 16, 20, 0.04, 0, 0);
    camera.bands = test::narrow();
    camera.samples_u = camera.samples_v = 4;
    simulation.instruments = {camera};
  }
  test::Image image(int levels, double sky_radiance, const render::RenderOptions& options = {}) {
    return lit(simulation, levels, kZenith_deg, 90, sky_radiance, options);
  }
};

double sunlight() { return kSunIrradiance * std::cos(kZenith_deg * kPi / 180); }

}  // namespace

// Nothing is drawn that matters: what is left is the skeleton's error, below a tenth of the tolerance of 3 %.
TEST_CASE("S23 plates: the sun comes, and is seen, through each of a pile of them") {
  for (const int plates : {1, 2, 3}) {
    Glazed scene(plates, 0.0);
    const auto image = scene.image(1, 0);
    CHECK(image.plan.matter.plates);
    CHECK(image.plan.matter.sides() == 1);
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      CAPTURE(plates);
      const double let = std::pow(at(scene.let, kCentres[b]), 2 * plates);
      check_mean(mean_of(image, static_cast<int>(b)), let * at(scene.ground, kCentres[b]) * sunlight() / kPi, 3e-3);
    }
  }
}

TEST_CASE("S23 plates: between ground and a plate light goes to and fro, and the plate sends its own") {
  // A faint sky beside the sun, then a sun beside a bright sky: the latter comes to the ground along paths alone.
  for (const double sky_radiance : {kSkyRadiance, 100 * kSkyRadiance}) {
    Glazed scene(1, 0.2);
    const auto image = scene.image(12, sky_radiance);
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      CAPTURE(sky_radiance);
      const double t = at(scene.let, kCentres[b]), rho = at(scene.ground, kCentres[b]), r = 0.2;
      const double down = sunlight() + kPi * sky_radiance;
      check_mean(mean_of(image, static_cast<int>(b)), down / kPi * (r + t * t * rho / (1 - r * rho)), 4e-3);
    }
  }
}

// 40 degrees from the zenith in the east, the sun comes to what is seen through the plate, which begins 1 m east of
// that.
TEST_CASE("S23 plates: open ground in a plate's shadow has the sun through it") {
  Glazed scene(1, 0.0, 1.0);
  const auto image = scene.image(4, 0);
  for (std::size_t b = 0; b < kCentres.size(); ++b)
    check_mean(mean_of(image, static_cast<int>(b)),
               at(scene.let, kCentres[b]) * at(scene.ground, kCentres[b]) * sunlight() / kPi, 3e-3);
  // Without paths it is opaque, and the plan says so.
  scene.simulation.bounces = 0;
  const auto dark = scene.image(0, 0);
  CHECK(mean_of(dark, 1).value < 1e-6);
  bool told = false;
  for (const auto& notice : dark.plan.notices) told = told || notice.find("plates") != std::string::npos;
  CHECK(told);
}

TEST_CASE("S23 plates: what they mirror by their gloss does not hang on what they let through") {
  Glazed bare(1, 0.0), glossy(1, 0.0);
  glossy.simulation.scene.materials[1].gloss = {RC_SHAPE_gloss, {0.5, 0.05}};
  for (auto* scene : {&bare, &glossy}) scene->simulation.scene.materials[0].reflectance = wavy(0, 0, 1);
  bare.simulation.scene.materials[1].gloss = glossy.simulation.scene.materials[1].gloss;
  bare.simulation.scene.materials[1].transmittance = {};
  const auto with = glossy.image(4, kSkyRadiance), without = bare.image(4, kSkyRadiance);
  for (int b = 0; b < static_cast<int>(kCentres.size()); ++b) {
    const auto one = mean_of(with, b), other = mean_of(without, b);
    CHECK_WITHIN(one.value - other.value, 4.5 * std::hypot(one.error, other.error) + 1e-6 * other.value);
  }
}

TEST_CASE("S23 plates: the same bits however it is run, and truth of what lies behind them") {
  Glazed scene(2, 0.1);
  scene.simulation.instruments[0].first_opaque = true;
  const auto image = scene.image(4, kSkyRadiance);
  render::RenderOptions little;
  little.threads = 1, little.tile_lines = 3, little.memory_bytes = std::size_t{32} << 20;
  const auto again = scene.image(4, kSkyRadiance, little);
  CHECK(image.radiance == again.radiance);
  CHECK(image.truth == again.truth);
  // A first look does not see what lies behind: every pixel has all its samples.
  scene.simulation.instruments[0].first_samples = 4;
  CHECK(scene.image(4, kSkyRadiance).radiance == image.radiance);
  // Shares of ground and glass as seen, then of what is opaque: all of it is glass, and ground.
  const int share = render::truth::abundance;
  CHECK(image.layer(3, 3, share) == 0);
  CHECK(image.layer(3, 3, share + 1) == doctest::Approx(1).epsilon(1e-6));
  CHECK(image.layer(3, 3, share + 2) == doctest::Approx(1).epsilon(1e-6));
  CHECK(image.layer(3, 3, share + 3) == 0);
}
