// Whether light goes between surfaces, by a look at what they see: against the series of two half planes that see each
// other.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/base/planck.h"
#include "host/planner/bounce_choice.h"
#include "host/planner/cost_model.h"
#include "host/planner/open_share.h"
#include "host/planner/pixel_trial.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

using namespace raycube;

namespace {

constexpr double kSunIrradiance = 1500, kSkyRadiance = 30, kFar_m = 2e4;

/// Endless ground, with an endless wall of the same matter west of it or none; seen from above 2 to 3 m before it.
scene::Simulation corner(bool wall, double reflectance, double tolerance, double zenith_deg = 40) {
  scene::Simulation s;
  s.file = "corner.toml", s.seed = testing::seed(s.seed);
  const auto grey = test::add_material(s.scene, "grey", reflectance);
  test::place(s.scene, test::rectangle({0, -kFar_m, 0}, {kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, grey));
  if (wall) test::place(s.scene, test::rectangle({0, -kFar_m, 0}, {0, 2 * kFar_m, 0}, {0, 0, kFar_m}, grey));
  finish_top_tree(s.scene);
  s.tolerance = tolerance;
  s.bounces = scene::kMostChosenBounces, s.bounces_given = false;
  s.sun.zenith_deg = zenith_deg, s.sun.azimuth_deg = 90;
  auto camera = test::nadir_camera(24, 24, 20, 0.04, 2.5, 0);
  camera.bands = test::gaussian_bands({0.5, 0.7}, 0.01);
  s.instruments = {camera};
  return s;
}

struct Chosen {
  plan::Plan plan;
  double before = 0;  ///< total error without
};
Chosen choose(const scene::Simulation& s) {
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return kSunIrradiance; };
  air.sky_radiance = [](double) { return kSkyRadiance; };
  air.sun_zenith_deg = s.sun.zenith_deg, air.sun_azimuth_deg = s.sun.azimuth_deg;
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.35, 1.0, 0.005));
  Chosen out{plan::make_plan(s, s.instruments[0], table, sensors::view_bounds(s.instruments[0])), 0};
  out.before = out.plan.report.total_error;
  render::Renderer renderer(s.scene, {});
  planner::measure_open_share(renderer, s, s.instruments[0], out.plan);
  const bool dropped = planner::choose_bounces(renderer, s, s.instruments[0], out.plan);
  CHECK(dropped == (!s.bounces_given && !out.plan.bounces.any()));
  return out;
}

/// What light scattered once misses of all light of the ground: either plane sees the other in half of its hemisphere
/// (the corner of render_bounces_test.cpp).
double once_missed(double reflectance, double zenith_deg) {
  const double angle = zenith_deg * std::numbers::pi / 180, sky = std::numbers::pi * kSkyRadiance / 2;
  double ground = reflectance * (kSunIrradiance * std::cos(angle) + sky),
         wall = reflectance * (kSunIrradiance * std::sin(angle) + sky), sum = ground;
  const double once = ground;
  for (int level = 0; level < 400; ++level) {
    const double next = reflectance * wall / 2;
    wall = reflectance * ground / 2, ground = next;
    sum += ground;
  }
  return 1 - once / sum;
}

/// Of a share of half, as 256 pixels of 16 rays at least know it, 4 standard errors.
constexpr double kNoise = 4 * 0.5 / 64;

}  // namespace

TEST_CASE("bounces = auto: where surfaces see each other paths keep the most surfaces that they may have") {
  const Chosen chosen = choose(corner(true, 0.9, 0.01));
  CHECK(chosen.plan.bounces.levels == scene::kMostChosenBounces);
  CHECK(chosen.plan.bounces.curve.size() > 0);
  CHECK(chosen.plan.report.bounces.chosen);
  CHECK(chosen.plan.report.bounces.missed < 1e-9);  // 0.45^64
  CHECK(chosen.plan.report.total_error == doctest::Approx(chosen.before));
  CHECK(chosen.plan.notices.empty());
  const plan::SkyRays::Met& met = chosen.plan.sky.met;
  CHECK(met.known);
  CHECK_WITHIN(met.mean - 0.5, kNoise);
  CHECK_WITHIN(met.on - 0.5, 2 * kNoise);
  CHECK_WITHIN(met.rms - 0.5, 2 * kNoise);
}

TEST_CASE("bounces = auto: what light scattered once misses is told from above, and decides") {
  struct Case {
    double reflectance, zenith_deg, tolerance;
    bool dropped;
  };
  for (const auto& [reflectance, zenith_deg, tolerance, dropped] : {Case{0.9, 40, 0.5, false},
                                                                    {0.1, 40, 0.1, false},
                                                                    {0.01, 40, 0.02, false},
                                                                    {0.01, 40, 0.2, true},
                                                                    {0.01, 80, 0.2, false}}) {
    CAPTURE(reflectance);
    CAPTURE(zenith_deg);
    CAPTURE(tolerance);
    const Chosen chosen = choose(corner(true, reflectance, tolerance, zenith_deg));
    const plan::BounceReport& report = chosen.plan.report.bounces;
    // Walls that face the sun are what it takes for: here they get 0.85 of the ground's light, and 0.65 of a sun's that
    // they faced; at 0.9 every second of the orders goes by the ground.
    const double truth = once_missed(reflectance, zenith_deg);
    CHECK_ABOVE(report.once_missed, truth);
    CHECK_BELOW(report.once_missed, 2.6 * truth);
    CHECK(chosen.plan.bounces.any() == !dropped);
    if (!dropped) continue;
    CHECK(report.missed == report.once_missed);
    CHECK(report.missed <= 0.1 * tolerance);
    CHECK(chosen.plan.report.total_error == doctest::Approx(std::hypot(chosen.before, report.missed)));
  }
}

TEST_CASE("bounces = auto: ground that sees nothing but sky has light scattered once") {
  const Chosen chosen = choose(corner(false, 0.9, 0.01));
  CHECK(chosen.plan.bounces.levels == 0);
  CHECK(!chosen.plan.bounces.any());
  CHECK(chosen.plan.report.bounces.chosen);
  CHECK(chosen.plan.report.bounces.once_missed == 0);
  CHECK(chosen.plan.report.total_error == chosen.before);
}

TEST_CASE("bounces = auto: what warm surfaces send onto others is measured, and kept where it is seen") {
  // By night at 10 um, wall and ground grey: L_g = e B_g + r (L_w + S) / 2 and so for L_w; light scattered once has the
  // surroundings' B for L_w.
  constexpr double um = 10, sky = 1;
  struct Case {
    double reflectance, wall_K, tolerance;
    bool dropped;
  };
  for (const auto& [reflectance, wall_K, tolerance, dropped] :
       {Case{0.3, 350, 0.01, false}, {0.3, 350, 0.9, true}, {0.02, 305, 0.05, true}, {0.3, 300, 0.01, false}}) {
    CAPTURE(reflectance);
    CAPTURE(wall_K);
    auto s = corner(true, reflectance, tolerance, 120);
    const auto wall = test::add_material(s.scene, "wall", reflectance);
    for (auto& material : s.scene.materials) material.reflectance = {{1.0, 20.0}, {reflectance, reflectance}};
    s.scene.materials[0].temperature_K = 300, s.scene.materials[1].temperature_K = wall_K;
    test::place(s.scene, test::rectangle({0.001, -kFar_m, 0}, {0, 2 * kFar_m, 0}, {0, 0, kFar_m}, wall));
    finish_top_tree(s.scene);
    s.instruments[0].bands = test::gaussian_bands({um}, 0.02);
    atmos::UniformAir air;
    air.solar_irradiance = air.sky_radiance = [](double) { return 0.0; };
    air.thermal_sky_radiance = [](double) { return sky; };
    air.thermal_path_radiance = [](double) { return 0.0; };
    air.sun_zenith_deg = 120;
    plan::Plan plan =
        plan::make_plan(s, s.instruments[0], atmos::uniform_table(air, atmos::wavelength_grid(9.5, 10.5, 0.01)),
                        sensors::view_bounds(s.instruments[0]));
    render::Renderer renderer(s.scene, {});
    planner::measure_open_share(renderer, s, s.instruments[0], plan);
    CHECK(planner::choose_bounces(renderer, s, s.instruments[0], plan) == dropped);
    const double e = 1 - reflectance, r = reflectance, ground_B = base::planck_radiance(um, 300);
    const double own = e * ground_B + r * sky / 2, wall_own = e * base::planck_radiance(um, wall_K) + r * sky / 2;
    const double all = (own + r * wall_own / 2) / (1 - r * r / 4),
                 once = own + r * base::planck_radiance(um, plan.thermal.surroundings_K) / 2;
    MESSAGE(plan.report.bounces.once_missed << " for " << std::abs(once / all - 1));
    // It is rounded up to an eighth of an octave, of what two draws of 512 pixels know to a few percent.
    CHECK_BETWEEN(plan.report.bounces.once_missed / std::abs(once / all - 1), 0.95, 1.05 * std::exp2(1.0 / 8));
    CHECK(plan.bounces.any() == !dropped);
  }
}

TEST_CASE("bounces = auto: black matter among the scene's is none of its light's") {
  auto s = corner(true, 0.9, 0.4);
  const auto black = test::add_material(s.scene, "black", 0);
  test::place(s.scene, test::rectangle({1000, 1000, 1}, {1, 0, 0}, {0, 1, 0}, black));
  finish_top_tree(s.scene);
  const Chosen chosen = choose(s);
  CHECK(chosen.plan.bounces.strength > 0.1);
  CHECK(chosen.plan.bounces.strength <= 1);
  CHECK(chosen.plan.bounces.error < 1e-6);
  CHECK(chosen.plan.notices.empty());
}

TEST_CASE("bounces = auto: what the file gives stays") {
  auto s = corner(true, 0.9, 0.01);
  s.bounces = 3, s.bounces_given = true;
  const Chosen chosen = choose(s);
  CHECK(chosen.plan.bounces.levels == 3);
  CHECK(!chosen.plan.report.bounces.chosen);
}

TEST_CASE("the cost model counts the surfaces that a path comes to") {
  const Chosen chosen = choose(corner(true, 0.9, 0.01));
  const planner::PixelCounts counts = planner::pixel_counts(chosen.plan, 64, 32);
  CHECK(counts.paths == 16);
  // From either plane half of the paths meet the other; from the second on 0.9^3, then 0.9 of them go on.
  const double each = 0.5 + 0.25 + 0.25 * 0.729 * 0.5 / (1 - 0.9 * 0.5);
  CHECK_WITHIN(counts.path_surfaces / counts.paths / each - 1, 2 * kNoise / 0.5);
  CHECK(counts.rays() == counts.samples + counts.sun_rays + counts.sky_rays + counts.paths + 2 * counts.path_surfaces);
}

TEST_CASE("as many paths go with the sky's rays as err least for their time") {
  // Of grey matter paths carry most of the noise; of dark matter, whose sky is hidden as much, hardly any.
  for (const auto& [reflectance, several] : {std::pair{0.9, true}, {0.02, false}}) {
    CAPTURE(reflectance);
    auto s = corner(true, reflectance, 1e-4);
    s.bounces_given = true, s.bounces = 8;
    Chosen chosen = choose(s);
    render::Renderer renderer(s.scene, {});
    planner::PixelTrial trial(renderer, s, s.instruments[0], chosen.plan);
    const double look_error = trial.look().sky.estimate;
    const int per_two = trial.choose_paths();
    CHECK((per_two > 1) == several);
    if (per_two == 1) {
      CHECK(trial.look().sky.estimate == doctest::Approx(look_error));
      continue;
    }
    // Each number by itself: half the mean square of what two draws of rays differ by, times what a pixel takes.
    std::vector<double> square_time;
    double chosen_error = 0, chosen_square_time = 0;
    for (const int tried : {1, 2, 4, 8}) {
      chosen.plan.sky.paths_per_two = tried;
      planner::PixelTrial one(renderer, s, s.instruments[0], chosen.plan);
      const double error = one.look().sky.estimate;
      const auto cost_s = [&](int rays) {
        return planner::CostModel().seconds(planner::pixel_counts(chosen.plan, 0, rays));
      };
      square_time.push_back(error * error * (cost_s(64) - cost_s(32)));
      if (tried == per_two) chosen_error = error, chosen_square_time = square_time.back();
    }
    CHECK_BELOW(chosen_square_time, 0.9 * square_time[0]);
    CHECK_BELOW(chosen_square_time, 1.15 * *std::min_element(square_time.begin(), square_time.end()));
    // 576 pixels, two pairs of draws: the square of an error is known to 4 % and as much again by the look.
    CHECK_WITHIN(trial.look().sky.estimate / chosen_error - 1, 0.15);
  }
}
